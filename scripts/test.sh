#!/usr/bin/env bash
# Installs the requirements of the checks on Debian 12, runs them all, and ends with the line "N passed, N failed".
#   scripts/test.sh              every stage; clang-tidy on the sources that the last six hours changed
#   scripts/test.sh cpp python   only these stages
#   scripts/test.sh quick        format, lint and the quick tests on a development build: two minutes when it is warm
#   scripts/test.sh changed      format, lint and the tests that the changes since main touch, by place
#   scripts/test.sh all-tidy     clang-tidy on every source
#   scripts/test.sh wheel bpy45  the add-on inside the module of Blender 4.5 too
#   scripts/test.sh tsan         the data of threads under the thread sanitizer
#   scripts/test.sh bench        the small benchmarks: fails where quality or operations are worse than in bench/public.json
# The output of each stage is kept in out/test/STAGE.log, its results as JUnit files in out/test/STAGE/.
set -uo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

# The first stages run one after another. The others run two at a time, in this order: window waits for screens while
# the engine is compiled, and the short ones fill the end.
first=(format lint mypy wheel)
beside=(window cpp asan python tidy cuda blender bpy50)
at_night=(tsan bpy45) # only on request
by_name=(quick changed all-tidy bench) # only on request
tests_venv=$root/.venv-test

# Each stage is a function that runs with `set -e`. `prepare` installs what the requested ones need. Test runners leave
# their JUnit files in $results. A stage without any counts as one check; one that fails with no failed test, as one
# failed.

stage_format() {
  git ls-files '*.h' '*.cpp' '*.cu' | xargs clang-format --dry-run -Werror
}

stage_lint() {
  shellcheck -x -P SCRIPTDIR scripts/*.sh .ci/run
  "$tests_venv/bin/check-jsonschema" --builtin-schema vendor.github-workflows .github/workflows/*.yml
  "$tests_venv/bin/check-jsonschema" --builtin-schema vendor.citation-file-format CITATION.cff
  "$tests_venv/bin/check-jsonschema" --builtin-schema vendor.dependabot .github/dependabot.yml
  "$tests_venv/bin/check-jsonschema" --builtin-schema vendor.github-issue-forms .github/ISSUE_TEMPLATE/[!c]*.yml
  "$tests_venv/bin/ruff" check .
  "$tests_venv/bin/ruff" format --check .
  "$tests_venv/bin/python" scripts/plain_words.py
}

stage_mypy() { # types, strict, for the files in pyproject.toml
  "$tests_venv/bin/mypy"
}

stage_wheel() { # the wheel of `pip install .`, kept for the stages that follow
  build_wheel "$tests_venv" --config-settings cmake.define.ISIMP_WERROR=ON
}

stage_cpp() { # the C++ tests; the engine as the wheel has it, by way of ccache
  cpp_tests build-test -DISIMP_CUDA=OFF
}

stage_python() { # the package as installed
  python_tests tests/python --ignore tests/python/blender
}

stage_blender() { # the add-on as packed, inside Debian's Blender, 3.4 on Debian 12
  make_addon
  local site=$out/blender/site
  rm -rf "$site"
  "$tests_venv/bin/pip" install -q --target "$site" pytest
  # Mesa's software renderer in one thread: it crashed once in a render of many threads on a busy machine.
  LP_NUM_THREADS=0 ISIMP_SITE=$site timeout 1200 blender -b --factory-startup --python-exit-code 1 \
    --python tests/python/blender/inside.py -- tests/python/blender --confcutdir tests/python/blender \
    -o pythonpath="$out/blender/addons" --junitxml "$results/pytest.xml"
}

stage_window() { # the add-on's buttons, pressed in a window of that Blender
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
  local venv=$root/.venv-bpy-$1
  bpy_venv "$1"
  install_wheel "$venv"
  timeout 1200 "$venv/bin/python" -m pytest tests/python/blender --junitxml "$results/pytest.xml"
}

stage_cuda() { # the CUDA part: compiled with nvcc, the machine's or PyPI's, and run where there is a device
  local tools=$tests_venv
  if ! PATH=$PATH:/usr/local/cuda/bin command -v nvcc; then
    tools=$root/.venv-cuda
    venv "$tools" nvidia-cuda-{nvcc,cccl,runtime,crt}==13.0.* nvidia-nvvm==13.0.*
    LIBRARY_PATH=$(echo "$tools"/lib/python3*/site-packages/nvidia/cu13/lib) # nvcc searches lib64
    export LIBRARY_PATH
  fi
  cmake -S . -B build-cuda -G Ninja -DISIMP_TESTS=ON -DISIMP_PYTHON=ON -DISIMP_WERROR=ON -DISIMP_CUDA=ON \
    -DCMAKE_UNITY_BUILD=ON -Dpybind11_DIR="$("$tests_venv/bin/python" -m pybind11 --cmakedir)" -DPython_EXECUTABLE="$tools/bin/python"
  local tests=(test_parallel test_thesis) test
  ninja -C build-cuda -j2 isimp_python test_stand_in "${tests[@]}"
  build-cuda/cuda/test_stand_in --gtest_output=xml:"$results/test_stand_in.xml"
  for test in "${tests[@]}"; do "build-cuda/tests/cpp/$test" --gtest_output=xml:"$results/$test.xml"; done
  ISIMP_CUDA_BUILD=$root/build-cuda PYTHONPATH=$root/build-cuda/python "$tests_venv/bin/python" -m pytest \
    tests/cuda tests/python/engine/test_parallel.py --junitxml "$results/pytest.xml"
}

stage_asan() { # the C++ tests under the address and undefined-behaviour sanitizers
  export UBSAN_OPTIONS=print_stacktrace=1 LSAN_OPTIONS=suppressions=$root/tests/cpp/leaks.txt
  export ISIMP_FUZZ_CASES=50 # the stage cpp runs all of them
  # clang compiles this in three quarters of the time of g++, and is a second compiler that must not warn. Its -O1 does
  # not inline, which makes the tests ten times as slow.
  cpp_tests build-asan -DISIMP_SANITIZE=ON -DISIMP_ASSERTIONS=ON -DISIMP_CUDA=OFF -DCMAKE_CXX_COMPILER=clang++ \
    -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O2\ -gline-tables-only
}

stage_tsan() { # the data of threads, under the thread sanitizer, which can't see OpenMP's; so without the thesis
  cmake -S . -B build-tsan -G Ninja -DISIMP_TESTS=ON -DISIMP_ASSERTIONS=ON -DISIMP_WERROR=ON -DISIMP_THESIS=OFF \
    -DISIMP_SANITIZE=thread -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1\ -g1 \
    -DPython_EXECUTABLE="$tests_venv/bin/python"
  local tests=(test_core test_mesh test_partition test_meshing test_texture) test
  ninja -C build-tsan -j2 "${tests[@]}" test_thesis
  build-tsan/tests/cpp/test_thesis --gtest_output=xml:"$results/test_thesis.xml"
  for test in "${tests[@]}"; do
    TSAN_OPTIONS=halt_on_error=1 timeout 600 "build-tsan/tests/cpp/$test" --gtest_filter='*Thread*' \
      --gtest_output=xml:"$results/$test.xml"
  done
}

stage_tidy() { # clang-tidy, on the sources and headers whose code changed in the last six hours
  local since sources
  since=${ISIMP_TIDY_SINCE:-$(git rev-list -1 --before='6 hours ago' HEAD)}
  prepare_tidy
  mapfile -t sources < <("$python" scripts/tidy_sources.py "$since")
  [ ${#sources[@]} = 0 ] || run-clang-tidy -quiet -p build-tidy -j2 "${sources[@]/%/\$}"
}

stage_all-tidy() { # clang-tidy, on all of the engine's own sources
  prepare_tidy
  run-clang-tidy -quiet -p build-tidy -j2 "^$root/native/src/"
}

stage_bench() { # made scans, by the wheel; instructions are counted by valgrind, so times do not matter
  build_wheel "$tests_venv" --config-settings cmake.define.ISIMP_CUDA=OFF
  install_wheel "$tests_venv"
  "$tests_venv/bin/python" -m bench.public small --against bench/public.json --json "$results/small.json"
}

prepare_tidy() { # the compile commands of each source by itself, so that it must include what it uses
  cmake -S . -B build-tidy -G Ninja -DISIMP_CUDA=OFF
}

stage_quick() { # the stage to run many times an hour while a change is made
  stage_format
  stage_lint
  development_build
  ctest --test-dir build-dev -j2 --timeout 120 --output-on-failure --output-junit "$results/ctest.xml"
  PYTHONPATH=$root/build-dev/python python_tests tests/python --ignore tests/python/blender -n 2 -m "not slow"
}

stage_changed() { # the tests of changed files, by place; scripts/affected_tests.py has the rules
  local since labels tests
  since=${ISIMP_CHANGED_SINCE:-$(git merge-base HEAD main)}
  stage_format
  stage_lint
  development_build
  labels=$("$python" scripts/affected_tests.py ctest build-dev "$since")
  [ -z "$labels" ] || ctest --test-dir build-dev -j2 --timeout 120 --output-on-failure -L "$labels" -LE slow \
    --output-junit "$results/ctest.xml"
  mapfile -t tests < <("$python" scripts/affected_tests.py pytest build-dev "$since")
  [ ${#tests[@]} = 0 ] || PYTHONPATH=$root/build-dev/python python_tests "${tests[@]}" -n 2 -m "not slow"
}

python_tests() { # ARGUMENT... of pytest. Batches and tiles wait for the disk after each file, so files are in memory if 2 GB are free
  local folder=${TMPDIR:-/tmp} free
  free=$(df -Pk /dev/shm 2>/dev/null | awk 'NR == 2 { print $4 }')
  if [ "${free:-0}" -gt 2000000 ] && [ -w /dev/shm ]; then
    folder=$(mktemp -d /dev/shm/isimp-tests-XXXXXX)
    trap 'rm -rf "'"$folder"'"' EXIT # each stage has a shell of its own
  fi
  TMPDIR=$folder "$tests_venv/bin/python" -m pytest --junitxml "$results/pytest.xml" "$@"
}

development_build() { # build-dev, with the Python module
  cpp_build build-dev -DISIMP_PYTHON=ON -DISIMP_CUDA=OFF \
    -Dpybind11_DIR="$("$tests_venv/bin/python" -m pybind11 --cmakedir)"
}

use_tests_venv() { # without cjio, which makes all JSON of a process round its numbers
  local requirements=()
  [ -e pyproject.toml ] && mapfile -t requirements < <(build_requirements)
  venv "$tests_venv" pytest pytest-xdist hypothesis mypy ruff==0.14.* numpy pillow distributed nvidia-cuda-cuobjdump==13.* \
    check-jsonschema mkdocs-material cadquery-ocp-novtk ezdxf ifcopenshell trimesh lxml networkx numpy-stl pyvista \
    mujoco "${requirements[@]}"
}

cpp_build() { # BUILD_DIR CMAKE_OPTION...
  local build=$1
  shift
  cmake -S . -B "$build" -G Ninja -DISIMP_TESTS=ON -DISIMP_WERROR=ON \
    -DPython_EXECUTABLE="$tests_venv/bin/python" "$@"
  ninja -C "$build" -j2
}

cpp_tests() { # BUILD_DIR CMAKE_OPTION...
  cpp_build "$@" -DCMAKE_UNITY_BUILD=ON
  local build=$1
  ctest --test-dir "$build" -j2 --timeout 600 --output-on-failure --output-junit "$results/ctest.xml"
}

run_stage() { # NAME: writes its output to a log, its counts to out/test/NAME.counts
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
  echo "${counts[*]}" >"$out/test/$name.counts"
  printf '%-8s %4d passed, %d failed, %d skipped  (%d s)\n' "$name" "${counts[@]}" $((SECONDS - started))
  if [ "${counts[1]}" != 0 ]; then tail -n 80 "$log" | sed 's/^/    /'; fi
}

run_stages() { # the requested ones of STAGE...
  local name
  for name; do
    if requested "$name"; then run_stage "$name"; fi
  done
}

run_beside() { # as run_stages, two at a time
  local name running=0
  for name; do
    requested "$name" || continue
    if [ $running = 2 ]; then
      wait -n
      running=1
    fi
    run_stage "$name" &
    running=$((running + 1))
  done
  wait
}

requested() { # whether one of STAGE... is
  local name
  for name; do
    case " ${asked[*]} " in *" $name "*) return 0 ;; esac
  done
  return 1
}

# Installs the packages that the requested stages need, of Debian and of Python.
prepare() {
  local packages=() pip
  use_tests_venv &
  pip=$!
  requested format quick changed && packages+=(clang-format)
  requested lint quick changed && packages+=(shellcheck)
  requested wheel cpp cuda asan tsan tidy "${by_name[@]}" && packages+=("${build_packages[@]}" libgtest-dev)
  requested asan && packages+=(clang libclang-rt-dev libomp-dev)
  requested tidy all-tidy && packages+=(clang-tidy libomp-dev) # for omp.h, which the CPU back end includes
  requested bench && packages+=(valgrind)
  requested blender window bpy50 bpy45 && packages+=("${blender_packages[@]}" libsm6 xvfb xauth imagemagick)
  apt_install "${packages[@]}" && wait "$pip"
}

for name; do
  case " ${first[*]} ${beside[*]} ${at_night[*]} ${by_name[*]} " in
    *" $name "*) ;;
    *) echo "no stage is called $name; there are: ${first[*]} ${beside[*]} ${at_night[*]} ${by_name[*]}" >&2 && exit 2 ;;
  esac
done
asked=("$@")
[ $# = 0 ] && asked=("${first[@]}" "${beside[@]}")
apt_install python3 python3-venv || exit 1
mkdir -p "$out/test"
rm -f "$out"/test/*.counts
prepare >"$out/test/prepare.log" 2>&1 </dev/null || { cat "$out/test/prepare.log"; exit 1; }
# The big download runs while the engine is compiled.
if requested bpy50; then bpy_venv 5.0.1 >"$out/test/downloads.log" 2>&1 </dev/null & fi
run_stages "${by_name[@]}" "${first[@]}"
if requested python window; then install_wheel "$tests_venv"; fi # once, as both read it
wait
run_beside "${beside[@]}" "${at_night[@]}"
read -ra total < <(cat "$out"/test/*.counts | awk '{ p += $1; f += $2; s += $3 } END { print p + 0, f + 0, s + 0 }')
[ "${total[2]}" = 0 ] && more= || more=", ${total[2]} skipped"
echo "${total[0]} passed, ${total[1]} failed$more"
[ "${total[1]}" = 0 ]
