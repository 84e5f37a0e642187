"""The output of nvcc, in the build folder named by ISIMP_CUDA_BUILD: run by the stage `cuda` of scripts/test.sh."""

import json
import os
import re
import shlex
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
from isimp_engine import _core

BUILD = Path(os.environ["ISIMP_CUDA_BUILD"])
PTX, MACHINE = 1, 2  # kinds of code in a fat binary


def compile_command() -> list[str]:
    """The compile command of kernels.cu."""
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        if entry["file"].endswith("kernels.cu"):
            words = shlex.split(entry["command"])
            return words[next(i for i, word in enumerate(words) if word.endswith("nvcc")) :]
    raise AssertionError("kernels.cu was not compiled")


def fat_binary(path: Path) -> set[tuple[int, int]]:
    """(kind, architecture) of each piece of device code in a file.

    A container begins with a magic number, two shorts and its size; a piece with its kind, its header's size and its
    own, and has its architecture at 28.
    """
    content, found = path.read_bytes(), set()
    for start in re.finditer(re.escape(struct.pack("<I", 0xBA55ED50)), content):
        _, header, size = struct.unpack_from("<HHQ", content, start.start() + 4)
        at = start.start() + header
        end = at + size
        while at < end:
            kind, _, head, length = struct.unpack_from("<HHIQ", content, at)
            found.add((kind, struct.unpack_from("<I", content, at + 28)[0]))
            at += head + length
    return found


def _paths_of_toolkits() -> list[str]:
    """The folders of CUDA's programs in PyPI's packages."""
    return [f"{path}/nvidia/cu13/bin" for path in sys.path]


def test_the_module_is_the_one_with_cuda_and_loads_without_a_driver():
    assert Path(_core.__file__).is_relative_to(BUILD)
    assert engine.backends()[0] == "cpu"
    if engine.backends() == ["cpu"]:
        mesh = engine.Mesh(np.eye(3), np.array([[0, 1, 2]]))
        options = engine.PartitionOptions(proxies=1, method="queued", backend="cuda")
        with pytest.raises(
            engine.InvalidInput, match=r"^back end 'cuda' is not available here: .+; there is: cpu$"
        ) as e:
            engine.partition(mesh, options)
        assert "left out of this build" not in str(e.value)


def test_the_module_asks_for_no_library_of_cuda():
    needed = subprocess.run(["readelf", "-d", _core.__file__], capture_output=True, text=True, check=True).stdout
    assert "NEEDED" in needed
    assert not re.search(r"NEEDED.*(cuda|cudart|nvrtc|nvidia)", needed)


def replaceable(path: Path) -> set[str]:
    """The functions of an object file that a linker may replace by another file's."""
    lines = subprocess.run(["nm", "-C", "--defined-only", path], capture_output=True, text=True, check=True).stdout
    return set(re.findall(r"^\w+ [WVu] (.*isimp::parallel::.*)$", lines, re.MULTILINE))


def test_no_function_of_one_back_end_can_stand_for_that_of_the_other():
    """Both may define the functions of the types that they share, which are in public headers."""
    cpu, cuda = (replaceable(next(BUILD.rglob(name))) for name in ("cpu_kernels.cpp.o", "kernels.cu.o"))
    assert min(len(cpu), len(cuda)) > 20
    own = re.compile(r"isimp::parallel::(?!(?:Flooder|Kernels|Proxies|RegionSum|FloodSurface)\b)\w")
    assert [name for name in sorted(cpu & cuda) if own.search(name)] == []


def test_there_is_code_for_every_architecture_up_to_12_0_and_for_later_ones():
    nvcc = compile_command()[0]
    known = subprocess.run([nvcc, "--list-gpu-arch"], capture_output=True, text=True, check=True).stdout.split()
    wanted = {a for a in (60, 70, 75, 80, 86, 89, 90, 100, 120) if f"compute_{a}" in known}
    code = fat_binary(Path(_core.__file__))
    assert {a for kind, a in code if kind == MACHINE} >= wanted
    assert max(wanted) in {a for kind, a in code if kind == PTX}


def test_arithmetic_is_rounded_as_on_the_processor(tmp_path):
    """No multiplication is fused with an addition, nothing is flushed to zero or approximated."""
    words = [word for word in compile_command() if not word.startswith(("--generate-code", "-arch", "-gencode"))]
    at = words.index("-o")
    del words[at : at + 2]
    words.remove("-c")
    ptx = tmp_path / "kernels.ptx"
    subprocess.run([*words, "-arch=compute_90", "-ptx", "-o", ptx], cwd=BUILD, check=True)
    code = ptx.read_text()
    assert len(re.findall(r"\b(?:add|sub|mul)\.rn\.f32\b", code)) > 20
    wrong = r"\bfma\.\S*f(?:32|64)|\.ftz|\.approx|\.full|\b(?:add|sub|mul|div|sqrt)\.f(?:32|64)"
    assert not re.findall(wrong, code)


def test_no_kernel_needs_memory_of_its_own_or_too_many_registers():
    """Except ChooseNear, which keeps its candidates there: 2 x 32 numbers."""
    dump = shutil.which("cuobjdump", path=os.pathsep.join([*_paths_of_toolkits(), os.environ["PATH"]]))
    if dump is None:
        pytest.skip("no cuobjdump is here: pip install nvidia-cuda-cuobjdump")
    used = subprocess.run(
        [dump, "-res-usage", next(BUILD.rglob("kernels.cu.o"))], capture_output=True, text=True, check=True
    ).stdout
    kernels = re.findall(r"Function (\S*run_(?:kernel|steps)\S*):\s+REG:(\d+) STACK:(\d+) SHARED:\d+ LOCAL:(\d+)", used)
    assert len(kernels) >= 19
    for name, registers, stack, local in kernels:
        most = 264 if "ChooseNear" in name else 0
        assert int(registers) <= 64, name
        assert int(stack) + int(local) <= most, name
