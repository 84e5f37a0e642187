"""The command `isimp`: `isimp simplify INPUT OUTPUT`, `isimp batch ...`, `isimp tiles ...`, `isimp info INPUT` ...

Exit status: 0; 2 for wrong usage; 3 for unusable input, with one line that names the error and its place; 4 if some
scans of a batch failed; 130 after Ctrl-C and 143 after SIGTERM, with nothing half-written.
"""

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    from .command import main  # here, so that batches and tiles can use a part without the whole

    return main(arguments)
