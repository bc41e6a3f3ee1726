"""The manual of the parameters: what the comments in config/*.yaml say of each, for documentation and for tools.

A comment stands before the parameter that it explains, and holds for those that follow it without a blank line. A
comment line that begins with a parameter's name and a colon explains that one alone; a parameter that is itself
commented out has a default that follows from others.
"""

import re
from typing import Dict, List

from social_fleet.errors import InvalidParameter
from social_fleet.files import PathLike

_ENTRY = re.compile(r"(# )?([a-z]\w*):(?:\s+(.*))?$")


def read_manual(path: PathLike) -> Dict[str, str]:
    """What a configuration file says of its parameters: text by name, in the file's order.

    Raises
    ------
    InvalidParameter
        When the file cannot be read.
    """
    try:
        with open(path, encoding="utf-8") as stream:
            lines = stream.read().splitlines()
    except OSError as error:
        raise InvalidParameter(f"cannot be read: {error.strerror}", source=str(path)) from error
    entries: Dict[str, str] = {}
    text: List[str] = []
    explained = ""  # the parameter that the comment is about, where it says so itself
    written = {line.split(":")[0] for line in lines if re.match(r"[a-z]\w*:", line)}
    for line in lines:
        match = _ENTRY.match(line)
        if not line.strip():
            text, explained = [], ""
        elif match and match.group(1) and match.group(2) in written:
            first = match.group(3) or ""
            text, explained = [first[:1].upper() + first[1:]], match.group(2)
        elif match and (not match.group(1) or _is_value(match.group(3))):
            if text and explained in ("", match.group(2)):
                entries[match.group(2)] = " ".join(text)
        elif line.startswith("#") and not line.startswith("#  "):  # an example is indented
            text.append(line[1:].strip())
    return entries


def _is_value(text: str) -> bool:
    """Whether what follows a commented-out name is a value, not a sentence."""
    return bool(text) and " " not in text
