# Sourced by the other scripts: paths, and functions that install missing packages.
# shellcheck shell=bash disable=SC2034

cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1
root=$PWD
out=$root/out
mkdir -p "$out"
python=/usr/bin/python3 # the one that Debian's Blender embeds, not the first on PATH
export CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1 PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_ROOT_USER_ACTION=ignore

build_packages=(build-essential cmake ninja-build ccache libcgal-dev libeigen3-dev libopenmesh-dev python3-dev python3-venv)
blender_packages=(blender python3-numpy libegl1 libgl1-mesa-dri) # the latter two to render in the background

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi
}

# apt_install PACKAGE...: installs the missing ones.
apt_install() {
  local package missing=()
  for package; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done
  [ ${#missing[@]} = 0 ] && return
  echo "installing ${missing[*]}"
  as_root apt-get update -qq &&
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends "${missing[@]}" >/dev/null
}

# venv DIR REQUIREMENT...: rebuilt only when the requirements have changed.
venv() {
  local dir=$1
  shift
  [ "$(cat "$dir/requirements" 2>/dev/null)" = "$*" ] && return
  rm -rf "$dir"
  echo "installing $* into ${dir#"$root/"}"
  "$python" -m venv "$dir" && "$dir/bin/pip" install -q "$@" && echo "$*" >"$dir/requirements"
}

# The requirements of pyproject.toml to build the package, one a line.
build_requirements() {
  "$python" -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["build-system"]["requires"], sep="\n")'
}

# has_extensions: whether the Blender on the PATH is 4.2 or later. An older one takes no notice of --command, and exits 0.
has_extensions() {
  local version
  version=$(blender --version 2>/dev/null | sed -n '1s/^Blender //p')
  [ -n "$version" ] && printf '4.2\n%s\n' "$version" | sort -C -V
}

# build_wheel VENV [OPTION...]: our package with CUDA where nvcc is found, into out/wheel; the second time only changed
# files are compiled.
build_wheel() {
  local venv=$1
  shift
  rm -rf "$out/wheel"
  # The compiler has the name that CMake uses without pip: ccache treats other names as other compilers.
  CC=cc CXX=c++ "$venv/bin/pip" wheel . --no-deps --no-build-isolation -w "$out/wheel" --config-settings build-dir=build-wheel "$@"
}

# install_wheel VENV [OPTION...]: the package that build_wheel made.
install_wheel() {
  local venv=$1
  shift
  "$venv/bin/pip" install -q --no-deps --force-reinstall "$@" "$out"/wheel/isimp-*.whl
}

# make_addon: the zips of the add-on with that wheel in it, and the legacy one put where Debian's Blender finds it.
make_addon() {
  "$python" scripts/build_addon.py --wheel "$out"/wheel/isimp-*.whl --out "$out/addon" >/dev/null || return
  rm -rf "$out/blender/addons/isimp"
  mkdir -p "$out/blender/addons"
  "$python" -m zipfile -e "$out"/addon/isimp-*-legacy-*.zip "$out/blender/addons" && export BLENDER_USER_SCRIPTS=$out/blender
}
