#!/usr/bin/env bash
# Runs the window tests in the Blender of another Debian, by hand, as root: trixie has 4.3, sid 5.2.
#   scripts/window_in_chroot.sh trixie|sid DIR [SCENARIO...]
# DIR is made by debootstrap if it is missing (2 GB, some minutes) and kept. The engine is built in there, or taken from
# $ISIMP_WHEEL if that names a wheel for the Python of that Debian. Pictures are written to out/window-SUITE.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

suite=${1:?trixie or sid} chroot=$(realpath -m "${2:?a folder for the chroot}")
shift 2
packages=(blender python3-numpy python3-venv xvfb xauth imagemagick libgl1-mesa-dri libegl1 libgomp1 libgmp10)
[ "$suite" = sid ] && packages+=(python3-cattr python3-requests python3-zstandard)
[ -n "${ISIMP_WHEEL:-}" ] || packages+=("${build_packages[@]}")

if [ ! -e "$chroot/etc/apt" ]; then
  apt_install debootstrap
  debootstrap --variant=minbase "$suite" "$chroot"
fi
ln -sf /proc/self/mounts "$chroot/etc/mtab"
echo 'Acquire::Check-Valid-Until "false";' >"$chroot/etc/apt/apt.conf.d/90-old"
cp -L /etc/resolv.conf "$chroot/etc/resolv.conf"
cp /etc/ssl/certs/ca-certificates.crt "$chroot/opt/certificates.crt" # pip brings none that a network of one's own needs
mkdir -p "$chroot/isimp" "$chroot/shared"
[ -z "${ISIMP_WHEEL:-}" ] || cp "$ISIMP_WHEEL" "$chroot/opt/"

# The mounts vanish with the process.
export chroot root
exec unshare --mount bash -euo pipefail -s -- "$suite" "${packages[*]}" "$(basename "${ISIMP_WHEEL:-}")" "$@" <<'OUTSIDE'
for name in proc sys dev; do mount --rbind "/$name" "$chroot/$name"; done
mount --bind "$root" "$chroot/isimp"
[ ! -d "$root/../shared" ] || mount --bind "$root/../shared" "$chroot/shared"
exec chroot "$chroot" /usr/bin/env -i HOME=/tmp PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
  PIP_CERT=/opt/certificates.crt PIP_ROOT_USER_ACTION=ignore bash -euo pipefail -s -- "$@" <<'INSIDE'
suite=$1 packages=$2 wheel=$3
shift 3
if ! dpkg-query -W $packages >/dev/null 2>&1; then
  apt-get update -qq
  DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends $packages >/dev/null
fi
blender --version | head -1
venv=/opt/venv
[ -d $venv ] || python3 -m venv --system-site-packages $venv
$venv/bin/pip install -q pytest
$venv/bin/pip install -q --force-reinstall --no-deps "${wheel:+/opt/}${wheel:-/isimp}"
cd /isimp
chosen=$(IFS='|'; echo "$*" | sed 's/|/ or /g')
export ISIMP_WINDOW_OUT=/isimp/out/window-$suite ISIMP_DATA=/shared/data
$venv/bin/python -m pytest -q -p no:cacheprovider tests/python/blender/window/test_window.py ${chosen:+-k "$chosen"}
INSIDE
OUTSIDE
