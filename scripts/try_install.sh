#!/usr/bin/env bash
# Tries the files of scripts/package.sh in dist/ as people do, and writes a table to out/try_install/table.md.
#   scripts/try_install.sh [CELL...]      some cells; the default is all
# Cells: bullseye bookworm trixie sid (bare chroots: the wheel by pip, then the whole job; in bullseye by a Python 3.11
# that is compiled there, which takes minutes and is kept), bpy-VERSION (Blender as a Python package: install from disk,
# enable, work, upgrade, uninstall, search for leftovers), blender (this Debian's, the same), blender-SUITE (the one of
# another Debian, in a chroot).
# Chroots and Blenders are kept in ~/.cache/isimp, or in $ISIMP_CACHE. Chroots need root. It exits 1 if a cell failed.
set -uo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

cells=("$@")
[ $# != 0 ] || cells=(bullseye bookworm trixie sid bpy-4.2.0 bpy-4.2.23 bpy-4.5.15 bpy-5.0.1 bpy-5.1.2 bpy-5.2.3 blender blender-trixie blender-sid)
cache=${ISIMP_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/isimp}
tried=$out/try_install
mkdir -p "$tried" "$cache/chroots"

# wheel_for PYTHON: the one in dist for it.
wheel_for() {
  find "$root/dist" -name "isimp-*-cp${1/./}-*.whl" | head -n 1
}

# fresh DIR: empties it, for Blender's files of a user.
fresh() {
  rm -rf "$1"
  mkdir -p "$1"
}

# zips KIND: the zip and the one of a next version.
zips() {
  local zip
  zip=$(find "$root/dist" -name "isimp-*-$1-linux-x64.zip" | head -n 1)
  [ -n "$zip" ] || { echo "dist has no $1 zip: run scripts/package.sh"; return 1; }
  echo "$zip"
  "$python" scripts/installed.py next "$zip" "$tried/next"
}

# make_chroot SUITE NAME PACKAGE...: a Debian with these packages, made once.
make_chroot() {
  local suite=$1 chroot=$cache/chroots/$2 packages
  [ ! -e "$chroot.done" ] || return 0
  packages=$(IFS=, && echo "${*:3}")
  apt_install debootstrap
  as_root rm -rf "$chroot" # left by a try that was ended
  if ! as_root debootstrap --variant=minbase --include="$packages" "$suite" "$chroot" >"$tried/$2.debootstrap" 2>&1; then
    echo "debootstrap failed"
    return 1
  fi
  touch "$chroot.done"
}

# newer_python CHROOT: Python 3.11 from the source of Debian 12, compiled once in an older Debian, in /opt/python there.
newer_python() {
  local chroot=$1
  [ ! -e "$chroot/opt/python/done" ] || return 0
  as_root cp -L /etc/resolv.conf "$chroot/etc/resolv.conf"
  # shellcheck disable=SC2016 # it is the chroot's shell that expands them
  as_root chroot "$chroot" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin sh -e -c '
    rm -rf /opt/source /opt/python
    mkdir -p /opt/source
    cd /opt/source
    echo "deb-src http://deb.debian.org/debian bookworm main" >sources.list
    from="-qq -o APT::Sandbox::User=root -o Dir::Etc::SourceList=/opt/source/sources.list -o Dir::Etc::SourceParts=-"
    apt-get $from update
    apt-get $from source --download-only python3.11
    tar -xzf python3.11_*.orig.tar.gz
    cd Python-3.11*
    ./configure -q --prefix=/opt/python OPT=-O1 --disable-test-modules --without-ensurepip
    make -s
    make -s install
    touch /opt/python/done' >"$chroot.python.log" 2>&1
}

try_chroot() { # SUITE
  local suite=$1 chroot=$cache/chroots/$1 version wheel tools=() interpreter=python3
  # Its Python 3.9 is older than all that have a wheel, so it gets a newer one.
  [ "$suite" != bullseye ] || tools=(gcc make libc6-dev zlib1g-dev libffi-dev)
  make_chroot "$suite" "$suite" python3 ca-certificates "${tools[@]}" || return
  if [ "$suite" = bullseye ]; then
    newer_python "$chroot" || { echo "Python 3.11 was not compiled: $(tail -n 1 "$chroot.python.log")"; return 1; }
    interpreter=/opt/python/bin/python3.11
  fi
  version=$(as_root chroot "$chroot" "$interpreter" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null)
  wheel=$(wheel_for "${version:-none}")
  [ -n "$wheel" ] || { echo "dist has no wheel for Python ${version:-none}: run scripts/package.sh"; return 1; }
  fresh "$tried/$suite"
  # numpy and pillow from outside, since a bare system has no pip.
  pip_for "$version" "$tried/$suite/site" "$wheel" || return 1
  fresh "$chroot/opt/isimp"
  cp -r "$tried/$suite/site/." "$chroot/opt/isimp/"
  cp scripts/installed.py "$chroot/opt/isimp/"
  as_root chroot "$chroot" env -i PATH=/usr/bin:/bin PYTHONPATH=/opt/isimp "$interpreter" /opt/isimp/installed.py package
}

# pip_for PYTHON FOLDER WHEEL: the files that pip would install for PYTHON, which may be another than the running one.
pip_for() {
  [ -e "$cache/pip/bin/pip" ] || "$python" -m venv "$cache/pip" || return 1
  if ! "$cache/pip/bin/pip" install -q --target "$2" --python-version "$1" --only-binary=:all: "$3" 2>"$2.log"; then
    tail -n 1 "$2.log"
    return 1
  fi
}

try_bpy() { # VERSION
  local venv=$cache/bpy-$1 interpreter archives
  interpreter=$(command -v python3.11) && case $1 in 5.[1-9]*) interpreter=$(newest_python 3.13) ;; esac
  [ -n "$interpreter" ] || { echo "no Python for it here"; return 1; }
  apt_install "${blender_packages[@]}" libsm6
  if [ ! -e "$venv/done" ]; then
    { "$interpreter" -m venv "$venv" && "$venv/bin/pip" install -q "bpy==$1" && touch "$venv/done"; } || return 1
  fi
  fresh "$tried/bpy-$1"
  mapfile -t archives < <(zips extension)
  [ ${#archives[@]} = 2 ] || { echo "${archives[*]}"; return 1; }
  in_blender "$tried/bpy-$1" "${archives[@]}" -- "$venv/bin/python" scripts/installed.py
}

# in_blender FOLDER ZIP NEXT -- COMMAND...: the four steps, each in a new process; prints their output.
in_blender() {
  local folder=$1 zip=$2 next=$3 step archive lines=""
  shift 4
  for step in install upgrade remove look; do
    [ $step = upgrade ] && archive=$next || archive=$zip
    if ! ISIMP_TRIED=$folder BLENDER_USER_RESOURCES=$folder BLENDER_USER_SCRIPTS=$folder/scripts timeout 600 \
      "$@" $step "$archive" >"$folder.$step.log" 2>&1 || ! grep -q '^SAID' "$folder.$step.log"; then
      echo "$step: $(grep -vE '^\s*$' "$folder.$step.log" | tail -n 1)"
      return 1
    fi
    lines+=${lines:+, }$(sed -n 's/^SAID //p' "$folder.$step.log")
  done
  echo "$lines"
}

newest_python() { # 3.13: one that runs, which a shim of pyenv may not
  local place
  for place in "$(command -v "python$1")" "${PYENV_ROOT:-$HOME/.pyenv}/versions/$1."*"/bin/python$1"; do
    if "$place" -c '' 2>/dev/null; then echo "$place" && return; fi
  done
}

try_blender() {
  local archives kind=legacy
  apt_install "${blender_packages[@]}"
  ! has_extensions || kind=extension
  fresh "$tried/blender"
  mkdir -p "$tried/blender/scripts/addons"
  mapfile -t archives < <(zips $kind)
  [ ${#archives[@]} = 2 ] || { echo "${archives[*]}"; return 1; }
  in_blender "$tried/blender" "${archives[@]}" -- \
    blender -b --factory-startup --python-exit-code 1 --python scripts/installed.py --
}

try_blender_of() { # SUITE
  local suite=$1 chroot=$cache/chroots/blender-$1 archives archive command=(chroot)
  [ "$(id -u)" = 0 ] || command=(sudo chroot)
  make_chroot "$suite" "blender-$suite" python3 ca-certificates || return
  as_root cp -L /etc/resolv.conf "$chroot/etc/resolv.conf"
  if [ ! -e "$chroot/usr/bin/blender" ] && ! as_root chroot "$chroot" env DEBIAN_FRONTEND=noninteractive sh -c '
    apt-get -o Acquire::Check-Valid-Until=false update -qq && apt-get install -qq -y --no-install-recommends \
    blender python3-numpy python3-cattr python3-requests python3-zstandard' >"$tried/blender-$suite.apt" 2>&1; then
    echo "apt failed: $(tail -n 1 "$tried/blender-$suite.apt")"
    return 1
  fi
  mapfile -t archives < <(zips extension)
  [ ${#archives[@]} = 2 ] || { echo "${archives[*]}"; return 1; }
  as_root rm -rf "$chroot/opt/tried"
  as_root mkdir -p "$chroot/opt/tried"
  as_root cp scripts/installed.py "$chroot/opt/"
  for archive in "${archives[@]}"; do # the same path in the chroot
    as_root mkdir -p "$chroot$(dirname "$archive")"
    as_root cp "$archive" "$chroot$archive"
  done
  in_blender "$tried/blender-$suite" "${archives[@]}" -- "${command[@]}" "$chroot" env -i HOME=/tmp LANG=C.UTF-8 \
    PATH=/usr/bin:/bin ISIMP_TRIED=/opt/tried BLENDER_USER_RESOURCES=/opt/tried \
    blender -b --factory-startup --python-exit-code 1 --python /opt/installed.py --
}

failed=0
printf '| where | result |\n|---|---|\n' >"$tried/table.md"
for cell in "${cells[@]}"; do
  case $cell in
    bullseye | bookworm | trixie | sid) result=$(try_chroot "$cell" 2>&1) ;;
    bpy-*) result=$(try_bpy "${cell#bpy-}" 2>&1) ;;
    blender-*) result=$(try_blender_of "${cell#blender-}" 2>&1) ;;
    blender) result=$(try_blender 2>&1) ;;
    *) echo "try_install.sh: no cell is called $cell" >&2 && exit 2 ;;
  esac
  code=$?
  [ $code = 0 ] || { failed=1 && result="FAILED: $result"; }
  printf '| %s | %s |\n' "$cell" "$(tail -n 1 <<<"$result")" | tee -a "$tried/table.md"
done
exit $failed
