"""Count what JUnit result files hold: prints ``PASSED FAILED SKIPPED`` for a file or a folder of them."""

import sys
from collections import Counter
from pathlib import Path
from typing import Iterator
from xml.etree import ElementTree


def outcomes(path: Path) -> Iterator[str]:
    """The outcome of every test in one result file; a file that is cut short is one failure."""
    try:
        cases = list(ElementTree.parse(path).iter("testcase"))
    except ElementTree.ParseError:
        yield "failed"
        return
    # rostest's own summary holds a case per test program; its tests are in the program's own file.
    summary = path.name.startswith("rostest-")
    for case in cases:
        if case.find("failure") is not None or case.find("error") is not None:
            yield "failed"
        elif not summary:
            yield "passed" if case.find("skipped") is None else "skipped"


def main() -> None:
    """Print the three counts."""
    given = Path(sys.argv[1])
    files = sorted(given.rglob("*.xml")) if given.is_dir() else [given] if given.exists() else []
    counts = Counter(outcome for path in files for outcome in outcomes(path))
    print(counts["passed"], counts["failed"], counts["skipped"])


if __name__ == "__main__":
    main()
