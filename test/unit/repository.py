"""Where the repository's files are, and what its Python files import."""

import ast
from pathlib import Path
from typing import Iterator, List, Tuple

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src" / "social_fleet"


def python_files(*folders: str) -> List[Path]:
    """Python files below `folders` of the repository, executables without suffix included."""
    found = []
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.is_file() and (path.suffix == ".py" or not path.suffix and "python3" in first_line(path)):
                found.append(path)
    return found


def first_line(path: Path) -> str:
    """The first line of a text file; empty for anything else."""
    with path.open("rb") as stream:
        return stream.readline(200).decode("ascii", errors="ignore")


def name_of(path: Path) -> str:
    """A file's name in messages and test ids: relative to the repository."""
    return str(path.relative_to(ROOT))


def imports(path: Path) -> Iterator[Tuple[str, int]]:
    """Every module that a file imports anywhere in it, as a dotted name with its line."""
    package = path.relative_to(SOURCE.parent).parts[:-1] if SOURCE in path.parents else ()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, node.lineno
        elif isinstance(node, ast.ImportFrom):
            base = package[:len(package) - node.level + 1] if node.level else ()
            module = ".".join([*base, *([node.module] if node.module else [])])
            for alias in node.names:
                yield f"{module}.{alias.name}", node.lineno
