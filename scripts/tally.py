"""Adds up the JUnit files of a folder: `tally.py DIR` prints how many tests passed, failed and were skipped."""

import sys
from pathlib import Path
from xml.etree import ElementTree


def outcome(case: ElementTree.Element) -> str:
    kinds = {child.tag for child in case}
    if kinds & {"failure", "error"}:
        return "failed"
    return "skipped" if "skipped" in kinds else "passed"


def main(folder: str) -> None:
    cases = [case for file in sorted(Path(folder).glob("*.xml")) for case in ElementTree.parse(file).iter("testcase")]
    outcomes = [outcome(case) for case in cases]
    print(*(outcomes.count(kind) for kind in ("passed", "failed", "skipped")))


if __name__ == "__main__":
    main(*sys.argv[1:])
