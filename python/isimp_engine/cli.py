"""The command `isimp`."""

import argparse
import sys
from collections.abc import Sequence

from . import __version__


def parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="isimp", description="Dense scans into clean, editable n-gon meshes.")
    parser.add_argument("--version", action="version", version=f"isimp {__version__}")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    parser().parse_args(arguments)
    parser().print_usage(sys.stderr)
    return 2
