"""What docstrings and pages name exists."""

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
NAMED = re.compile(r"`((?:kwatra|flow|synth)(?:\.\w+)+)[`(]")


def exists(name: str) -> bool:
    """Whether a dotted name is a module's, or of something in one."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            found = getattr(found, part, None)
        return found is not None
    return False


@pytest.mark.parametrize("name", ["kwatra.begin", "kwatra.pieces.cells", "flow.Frame", "synth.texture.tones"])
def test_what_is_there_is_found(name: str) -> None:
    assert exists(name)
    assert not exists(name + "s.none")
    assert not exists(name + "_of_none")


@pytest.mark.parametrize("folder", ["kwatra", "flow", "synth", "scripts", "docs", "README.md"])
def test_names_in_backticks_are_of_something(folder: str) -> None:
    path = ROOT / folder
    files = [path] if path.is_file() else [*path.rglob("*.py"), *path.rglob("*.md")]
    named = {name for file in files for name in NAMED.findall(file.read_text())}
    assert [name for name in sorted(named) if not exists(name)] == []
