#!/usr/bin/env bash
# Brings the CUDA part to a machine that has a device but no compiler and no network, and tries it there.
#   scripts/device.sh prepare FOLDER [SCAN...]   makes FOLDER and FOLDER.tar.xz: the engine with CUDA, numpy, tests,
#                                                benchmarks, scans
#   FOLDER/device.sh run                         on the other machine; writes its results to FOLDER/results
#
# `run` has a time limit for each step and ends after 12 minutes at most. Without a device it runs all steps that need
# none, and reports that.
# ISIMP_PYTHONS: the Pythons to build for, as commands; without it Debian's and, where pyenv has it, 3.12.
set -uo pipefail

prepare() { # FOLDER SCAN...
  # shellcheck source=scripts/common.sh
  . "$(dirname "${BASH_SOURCE[0]}")/common.sh"
  set -e
  local folder=$1 build=$root/build-device place version entries="" library scan
  shift
  apt_install "${build_packages[@]}" libgtest-dev
  mapfile -t requirements < <(build_requirements)
  venv "$root/.venv-device" numpy "${requirements[@]}"
  mkdir -p "$folder"/{python,numpy,lib,tests,bench/studies,scans}
  rm -f "$folder"/numpy/*
  for place in ${ISIMP_PYTHONS:-"$python" "$HOME"/.pyenv/versions/3.12.*/bin/python3}; do
    version=$("$place" -c 'import sys; print("%d.%d" % sys.version_info[:2])') || continue
    "$root/.venv-device/bin/pip" download -q --no-deps --only-binary=:all: --python-version "$version" -d "$folder/numpy" numpy
    entries+=$(python_entry "$place")\;
  done
  entries=$(tr ';' '\n' <<<"$entries" | grep -v "^$(python_entry "$python" | cut -d= -f1)=" | paste -sd';')
  cmake -S . -B "$build" -G Ninja -DISIMP_TESTS=ON -DISIMP_PYTHON=ON -DISIMP_CUDA=ON "-DISIMP_OTHER_PYTHONS=${entries%;}" \
    -DPython_EXECUTABLE="$root/.venv-device/bin/python" \
    -Dpybind11_DIR="$("$root/.venv-device/bin/python" -m pybind11 --cmakedir)" >/dev/null
  local tests=(test_parallel test_thesis)
  ninja -C "$build" -j2 native/bindings/all "${tests[@]}"
  cp -RLf "$build"/python/. "$folder/python"
  for place in "${tests[@]}"; do cp "$build/tests/cpp/$place" "$folder/tests"; done
  for library in $(ldd "$folder"/python/isimp_engine/_core*.so "$folder"/tests/* | sed -n 's/.*=> \(.*\/lib\(OpenMesh\|gomp\).*\) (.*/\1/p' | sort -u); do
    cp -L "$library" "$folder/lib"
  done
  cp bench/__init__.py "$folder/bench"
  cp bench/studies/gpu.py "$folder/bench/studies"
  for scan; do cp "$scan" "$folder/scans"; done
  strip "$folder"/python/isimp_engine/_core*.so "$folder"/tests/*
  cp scripts/device.sh "$folder"
  tar -C "$(dirname "$folder")" -c --use-compress-program="xz -T2 -3" -f "$folder.tar.xz" "$(basename "$folder")"
  du -m "$folder.tar.xz" | awk '{ print $2 ", " $1 " MB" }'
}

# python_entry PYTHON: SUFFIX=FOLDER of its headers.
python_entry() {
  "$1" -c 'import sysconfig; print(sysconfig.get_config_var("EXT_SUFFIX") + "=" + sysconfig.get_path("include"))'
}

# step NAME SECONDS COMMAND...: runs it with a time limit, its output to results/NAME.txt.
step() {
  local name=$1 limit=$2 started=$SECONDS code
  shift 2
  timeout "$limit" "$@" >"results/$name.txt" 2>&1 </dev/null
  code=$?
  [ $code = 0 ] || failed=1
  echo "$name: exit status $code after $((SECONDS - started)) s; $(tail -n 1 "results/$name.txt" | cut -c1-200)"
}

run() {
  cd "$(dirname "${BASH_SOURCE[0]}")" || exit 1
  mkdir -p results
  local python="" place version failed=0
  for place in python3 python3.1{4,3,2,1,0}; do
    version=$("$place" -c 'import sys; print("cp%d%d" % sys.version_info[:2])' 2>/dev/null) || continue
    if compgen -G "numpy/*-$version-*" >/dev/null; then python=$place && break; fi
  done
  [ -n "$python" ] || { echo "numpy/ has none of the Pythons here: $(echo numpy/*)"; exit 1; }
  "$python" -m zipfile -e numpy/*-"$version"-*.whl "unpacked/$version"
  export PYTHONPATH=$PWD/python:$PWD/unpacked/$version LD_LIBRARY_PATH=$PWD/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
  step machine 20 bash -c 'uname -a; nproc; nvidia-smi; true'
  step import 60 "$python" -c 'import isimp_engine as e; print(e.__version__, e.backends())'
  step tests_thesis 120 tests/test_thesis
  step tests 30 tests/test_parallel
  if ! grep -q cuda results/import.txt; then
    echo "no device here: $("$python" -c '
import isimp_engine as e, numpy as n
try: e.partition(e.Mesh(n.eye(3), n.array([[0, 1, 2]])), e.PartitionOptions(proxies=1, method="queued", backend="cuda"))
except e.InvalidInput as error: print(error)')"
    exit $failed
  fi
  step check 200 "$python" -m bench.studies.gpu --tests tests --faces 100000 --counts 100,1000 --out results/small
  step scans 120 "$python" -m bench.studies.gpu --faces 1000000 --counts 100,500,2000 --repeat 1 --out results/scans --scans scans/*
  step large 120 "$python" -m bench.studies.gpu --faces 3500000 --counts 500,2000 --repeat 1 --out results/large
  cat results/check.txt results/scans.txt results/large.txt
  exit $failed
}

case ${1:-} in
  prepare) prepare "${@:2}" ;;
  run) run ;;
  *)
    sed -n '2,10s/^# \{0,1\}//p' "$0"
    exit 2
    ;;
esac
