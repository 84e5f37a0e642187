#!/usr/bin/env bash
# Compiles the engine for systems that this machine is not, and runs its C++ tests where an emulator does it:
#   scripts/cross.sh [TARGET...]     aarch64-linux-musl, x86_64-windows-gnu, aarch64-macos; the default is all three
# The compiler is the clang of Python's package ziglang, with its own C++ library. The tests of aarch64 run under qemu,
# the tests of Windows under wine. They are compiled with -O1. For macOS there is no emulator, so the libraries alone
# are compiled, with -O0, to check that they compile. The methods of the thesis (Thrust, OpenMesh) are compiled with
# ISIMP_CROSS_THESIS=ON alone. The table is written to out/cross/table.md. It exits 1 if a target was not compiled whole
# or a test failed. ISIMP_CROSS_TESTS names the tests to run; the default is below.
set -uo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

targets=("$@")
[ $# != 0 ] || targets=(aarch64-linux-musl x86_64-windows-gnu aarch64-macos)
read -ra tests <<<"${ISIMP_CROSS_TESTS:-test_core test_mesh test_partition test_meshing}"
cross=$out/cross
tools=$root/.venv-cross
headers=${ISIMP_THIRD_PARTY:-${XDG_CACHE_HOME:-$HOME/.cache}/isimp/third_party}

# make_tools TARGET: makes the tools that CMake calls, in out/cross/TARGET/bin.
make_tools() {
  local bin=$cross/$1/bin name
  mkdir -p "$bin"
  for name in c++ ar ranlib; do
    printf '#!/bin/sh\nexec "%s" -m ziglang %s "$@"\n' "$tools/bin/python" "$name" >"$bin/$name"
    chmod +x "$bin/$name"
  done
}

# emulator TARGET: the emulator for its programs, empty if there is none.
emulator() {
  case $1 in
    aarch64-linux-*) command -v qemu-aarch64-static ;;
    *-windows-*) command -v wine64 /usr/lib/wine/wine64 | head -n 1 ;;
  esac
}

# compile TARGET: libraries, and tests where they can run; continues after an error, so that the log names all.
compile() {
  local build=$cross/$1/build level=-O0 programs=()
  [ -z "$(emulator "$1")" ] || { level=-O1 && programs=("${tests[@]}"); }
  make_tools "$1"
  cmake -S . -B "$build" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$root/cmake/zig.cmake" -DISIMP_ZIG_BIN="$cross/$1/bin" \
    -DISIMP_ZIG_TARGET="$1" -DCCACHE=OFF -DISIMP_BUNDLED=ON -DISIMP_FETCH=OFF -DISIMP_HEADERS="$headers" -DISIMP_CUDA=OFF \
    -DISIMP_THESIS="${ISIMP_CROSS_THESIS:-OFF}" -DISIMP_WERROR=ON -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="$level -DNDEBUG" -DPython_EXECUTABLE="$tools/bin/python" -DISIMP_TESTS=ON \
    -DISIMP_GTEST=/usr/src/googletest || return
  ninja -C "$build" -k 0 -j "${ISIMP_CROSS_JOBS:-2}" native/all "${programs[@]}"
}

# run TARGET: runs the tests and reports which passed.
run() {
  local program=$1 runner test passed=0 failed=()
  runner=$(emulator "$1")
  [ -n "$runner" ] || { echo "not run: no emulator for it"; return; }
  for test in "${tests[@]}"; do
    program=$cross/$1/build/tests/cpp/$test
    [ -e "$program" ] || program+=.exe
    if WINEDEBUG=-all WINEPREFIX=$cross/wine timeout 1200 "$runner" "$program" >"$cross/$1/$test.log" 2>&1; then
      passed=$((passed + $(sed -n 's/^\[  PASSED  \] \([0-9]*\) tests\?\..*/\1/p' "$cross/$1/$test.log")))
    else
      failed+=("$test")
    fi
  done
  echo "$passed tests passed by $(basename "$runner")${failed[*]:+; FAILED: ${failed[*]}}"
  [ ${#failed[@]} = 0 ]
}

apt_install cmake ninja-build googletest python3-venv
for target in "${targets[@]}"; do
  case $target in
    aarch64-linux-*) apt_install qemu-user-static ;;
    *-windows-*) apt_install wine64 ;;
  esac
done
mkdir -p "$cross"
venv "$tools" ziglang==0.17.1 nvidia-cuda-cccl==13.0.* || exit 1
[ -e "$headers/include/CGAL" ] || "$python" scripts/headers.py "$headers" || exit 1
failures=0
printf '| target | compiled | tests |\n|---|---|---|\n' >"$cross/table.md"
for target in "${targets[@]}"; do
  mkdir -p "$cross/$target"
  if compile "$target" >"$cross/$target/compile.log" 2>&1; then
    compiled="libraries of the engine"
    [ -z "$(emulator "$target")" ] || compiled+=", ${#tests[@]} test programs"
  else
    compiled="FAILED: $(grep -cE '^FAILED: ' "$cross/$target/compile.log") steps" failures=1
  fi
  ran=$(run "$target") || failures=1
  printf '| %s | %s | %s |\n' "$target" "$compiled" "$ran" | tee -a "$cross/table.md"
done
exit $failures
