#!/usr/bin/env bash
# Installs what the checks need on Debian 12, runs them all, and closes with the line "N passed, N failed".
#   scripts/test.sh              everything
#   scripts/test.sh cpp python   only these stages, in the order below
# The output of each stage is kept in out/test/STAGE.log, its results as JUnit files in out/test/STAGE/.
set -uo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

stages=(format lint cpp wheel python blender bpy45 bpy50 window asan tsan cuda tidy)
tests_venv=$root/.venv-test

# Each stage is a function that runs with `set -e`; what it needs installed it installs. Test runners leave their
# JUnit files in $results. A stage without any counts as one check; one that ends badly with no failed test, as one failed.

stage_format() {
  apt_install clang-format
  git ls-files '*.h' '*.cpp' '*.cu' | xargs clang-format --dry-run -Werror
}

stage_lint() {
  apt_install shellcheck
  use_tests_venv
  shellcheck -x -P SCRIPTDIR scripts/*.sh .ci/run
  "$tests_venv/bin/ruff" check .
  "$tests_venv/bin/ruff" format --check .
}

stage_cpp() { # the C++ tests, those of the benchmarks among them
  cpp_tests build-test -DISIMP_BENCH=ON -DISIMP_CUDA=OFF
}

stage_wheel() { # what `pip install .` makes, kept for the stages that follow
  apt_install "${build_packages[@]}"
  use_tests_venv
  build_wheel "$tests_venv"
}

stage_python() { # the package as installed
  use_tests_venv
  install_wheel "$tests_venv"
  "$tests_venv/bin/python" -m pytest tests/python --ignore tests/python/blender --junitxml "$results/pytest.xml"
}

stage_blender() { # the add-on as packed, inside Debian's Blender, 3.4 on Debian 12
  apt_install "${blender_packages[@]}"
  make_addon
  local site=$out/blender/site
  rm -rf "$site"
  "$tests_venv/bin/pip" install -q --target "$site" pytest
  ISIMP_SITE=$site timeout 1200 blender -b --factory-startup --python-exit-code 1 \
    --python tests/python/blender/inside.py -- tests/python/blender --confcutdir tests/python/blender \
    -o pythonpath="$out/blender/addons" --junitxml "$results/pytest.xml"
}

stage_window() { # the add-on's buttons, pressed in a window of that Blender
  apt_install "${blender_packages[@]}" xvfb xauth imagemagick
  use_tests_venv
  install_wheel "$tests_venv"
  timeout 3600 "$tests_venv/bin/python" -m pytest tests/python/blender/window --junitxml "$results/pytest.xml"
}

stage_bpy45() {
  bpy_tests 4.5.15
}

stage_bpy50() {
  bpy_tests 5.0.1
}

bpy_venv() { # VERSION
  venv "$root/.venv-bpy-$1" "bpy==$1" numpy pytest hypothesis
}

bpy_tests() { # VERSION: the add-on inside Blender as a Python module
  apt_install "${blender_packages[@]}" libsm6
  local venv=$root/.venv-bpy-$1
  bpy_venv "$1"
  install_wheel "$venv"
  timeout 1200 "$venv/bin/python" -m pytest tests/python/blender --junitxml "$results/pytest.xml"
}

stage_cuda() { # the CUDA part: compiled with nvcc, the machine's or PyPI's, and run where there is a device
  use_tests_venv
  local tools=$tests_venv
  if ! PATH=$PATH:/usr/local/cuda/bin command -v nvcc; then
    tools=$root/.venv-cuda
    venv "$tools" nvidia-cuda-{nvcc,cccl,runtime,crt}==13.0.* nvidia-nvvm==13.0.*
    LIBRARY_PATH=$(echo "$tools"/lib/python3*/site-packages/nvidia/cu13/lib) # nvcc looks in lib64
    export LIBRARY_PATH
  fi
  cmake -S . -B build-cuda -G Ninja -DISIMP_TESTS=ON -DISIMP_PYTHON=ON -DISIMP_WERROR=ON -DISIMP_CUDA=ON \
    -Dpybind11_DIR="$("$tests_venv/bin/python" -m pybind11 --cmakedir)" -DPython_EXECUTABLE="$tools/bin/python"
  local tests=(test_parallel test_parallel_lloyd test_device_memory) test
  ninja -C build-cuda -j2 isimp_python "${tests[@]}"
  for test in "${tests[@]}"; do "build-cuda/tests/cpp/$test" --gtest_output=xml:"$results/$test.xml"; done
  ISIMP_CUDA_BUILD=$root/build-cuda PYTHONPATH=$root/build-cuda/python "$tests_venv/bin/python" -m pytest \
    tests/cuda tests/python/test_parallel.py --junitxml "$results/pytest.xml"
}

stage_asan() { # the same under the address and undefined-behaviour sanitizers
  export UBSAN_OPTIONS=print_stacktrace=1
  cpp_tests build-asan -DISIMP_SANITIZE=ON -DISIMP_CUDA=OFF -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1\ -g1
}

stage_tsan() { # what threads share, under the thread sanitizer; OpenMP's own threads it can't see, so those tests stay out
  apt_install "${build_packages[@]}" libgtest-dev
  use_tests_venv
  cmake -S . -B build-tsan -G Ninja -DISIMP_TESTS=ON -DISIMP_ASSERTIONS=ON -DISIMP_WERROR=ON -DISIMP_CUDA=OFF \
    -DISIMP_SANITIZE=thread -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1\ -g1 \
    -DPython_EXECUTABLE="$tests_venv/bin/python"
  local tests=(test_threads test_mesh_threads test_partition_steps test_bound test_meshing_threads) test
  ninja -C build-tsan -j2 "${tests[@]}"
  for test in "${tests[@]}"; do
    TSAN_OPTIONS=halt_on_error=1 timeout 600 "build-tsan/tests/cpp/$test" --gtest_filter='*Thread*' \
      --gtest_output=xml:"$results/$test.xml"
  done
}

stage_tidy() { # clang-tidy, on the engine's own sources
  apt_install clang-tidy libomp-dev # its omp.h, which the CPU back end asks for
  cpp_build build-test -DISIMP_BENCH=ON -DISIMP_CUDA=OFF
  run-clang-tidy -quiet -p build-test -j2 "^$root/native/src/"
}

use_tests_venv() {
  local requirements=()
  [ -e pyproject.toml ] && mapfile -t requirements < <(build_requirements)
  venv "$tests_venv" pytest hypothesis ruff==0.14.* numpy "${requirements[@]}"
}

cpp_build() { # BUILD_DIR CMAKE_OPTION...
  apt_install "${build_packages[@]}" libgtest-dev
  use_tests_venv
  local build=$1
  shift
  cmake -S . -B "$build" -G Ninja -DISIMP_TESTS=ON -DISIMP_ASSERTIONS=ON -DISIMP_WERROR=ON \
    -DPython_EXECUTABLE="$tests_venv/bin/python" "$@"
  ninja -C "$build" -j2
}

cpp_tests() { # BUILD_DIR CMAKE_OPTION...
  cpp_build "$@"
  local build=$1
  ctest --test-dir "$build" -j2 --timeout 600 --output-on-failure --output-junit "$results/ctest.xml"
}

run_stage() {
  local name=$1 started=$SECONDS log=$out/test/$1.log code counts
  results=$out/test/$name
  rm -rf "$results"
  mkdir -p "$results"
  (
    set -e
    "stage_$name"
  ) >"$log" 2>&1 </dev/null
  code=$?
  read -ra counts < <("$python" scripts/tally.py "$results" || echo 0 1 0)
  if [ $code != 0 ] && [ "${counts[1]}" = 0 ]; then counts[1]=1; fi
  if [ "${counts[*]}" = "0 0 0" ]; then counts[0]=1; fi
  printf '%-8s %4d passed, %d failed, %d skipped  (%d s)\n' "$name" "${counts[@]}" $((SECONDS - started))
  if [ "${counts[1]}" != 0 ]; then tail -n 80 "$log" | sed 's/^/    /'; fi
  passed=$((passed + counts[0])) failed=$((failed + counts[1])) skipped=$((skipped + counts[2]))
}

apt_install python3 python3-venv || exit 1
mkdir -p "$out/test"
passed=0 failed=0 skipped=0
for name; do
  case " ${stages[*]} " in *" $name "*) ;; *) echo "no stage is called $name; there are: ${stages[*]}" >&2 && exit 2 ;; esac
done
[ $# = 0 ] && set -- "${stages[@]}"
# The two big downloads go on while the engine is compiled.
case " $* " in *" bpy"*) (bpy_venv 4.5.15; bpy_venv 5.0.1) >"$out/test/downloads.log" 2>&1 </dev/null & ;; esac
for name in "${stages[@]}"; do
  case $name in bpy*) wait ;; esac
  case " $* " in *" $name "*) run_stage "$name" ;; esac
done
[ $skipped = 0 ] && more= || more=", $skipped skipped"
echo "$passed passed, $failed failed$more"
[ $failed = 0 ]
