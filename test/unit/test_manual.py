"""Comments of a configuration file become the explanations of its parameters."""

from pathlib import Path

import pytest

from social_fleet.errors import InvalidParameter
from social_fleet.manual import read_manual

TEXT = """# What the file is.

# Both of these
# go together.
first: 1.0
second: 2.0

# Weights in general.
# heavy: what counts much.
heavy: 5.0
# light: what counts little.
light: 0.1

# Follows from others.
# third: 3.0

# With an example:
#   fourth: {a: 1}
fourth: {}

fifth: 5
"""


def test_what_the_comments_say(tmp_path: Path) -> None:
    file = tmp_path / "some.yaml"
    file.write_text(TEXT)
    assert read_manual(file) == {
        "first": "Both of these go together.", "second": "Both of these go together.", "heavy": "What counts much.",
        "light": "What counts little.", "third": "Follows from others.", "fourth": "With an example:"}


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InvalidParameter, match="cannot be read"):
        read_manual(tmp_path / "none.yaml")
