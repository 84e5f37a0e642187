#!/usr/bin/env bash
# The main job on a real scan, through Blender in the background: installs its requirements on Debian 12, builds the
# engine, and writes out/demo.blend, out/demo.obj and out/demo.png, whose path is the last line.
#   scripts/demo.sh                  the bunny at 200 regions
#   scripts/demo.sh SCAN REGIONS     another scan, in any format that Blender reads
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

# fetch_bunny FILE.off: the Stanford bunny of Debian's libcgal-demo, unpacked without installing it.
fetch_bunny() {
  local folder
  folder=$(dirname "$1")
  mkdir -p "$folder"
  (cd "$folder" && apt-get -qq -o APT::Sandbox::User=root download libcgal-demo && dpkg -x libcgal-demo_*.deb . && rm libcgal-demo_*.deb)
  tar -xOzf "$folder/usr/share/doc/libcgal-dev/data.tar.gz" data/meshes/bunny00.off >"$1"
}

apt_install python3 python3-venv "${build_packages[@]}" "${blender_packages[@]}"
mapfile -t requirements < <(build_requirements)
venv "$root/.venv-build" "${requirements[@]}"
build_wheel "$root/.venv-build" >"$out/build.log" 2>&1 || { tail -n 40 "$out/build.log"; exit 1; }
make_addon

if [ $# = 0 ]; then
  scan=$root/../shared/data/scan/bunny_69k.ply up=Y
  if [ ! -e "$scan" ]; then
    scan=$out/scan/bunny00.off
    [ -e "$scan" ] || fetch_bunny "$scan"
  fi
else
  scan=$1 up=Z
fi
blender -b --factory-startup --addons isimp --python-exit-code 1 --python examples/batch.py -- \
  "$scan" "$out/demo.blend" "$out/demo.obj" --proxies "${2:-200}" --up $up --picture "$out/demo.png" \
  >"$out/demo.log" 2>&1 || { tail -n 40 "$out/demo.log"; exit 1; }
grep ' faces -> ' "$out/demo.log"
echo "$out/demo.png"
