"""The house's law of size: a function is one thought, and a file can be read at one sitting."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FUNCTION, FILE = 45, 300
"""At most so many lines: of a function without its decorators and what says what it does, and of a file."""


def lines_of(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function, from its name on, but for its docstring."""
    said = ast.get_docstring(function, clean=False) is not None
    docstring = function.body[0]
    assert function.end_lineno is not None
    long = 1 + function.end_lineno - function.lineno
    return long - (1 + (docstring.end_lineno or 0) - docstring.lineno if said else 0)


@pytest.mark.parametrize("folder", ["kwatra", "flow", "synth", "scripts", "tests"])
def test_no_function_and_no_file_is_too_long(folder: str) -> None:
    files = sorted((ROOT / folder).rglob("*.py"))
    assert files
    for file in files:
        text = file.read_text()
        assert text.count("\n") <= FILE, file
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                assert lines_of(node) <= FUNCTION, f"{file}: {node.name} has {lines_of(node)} lines"


def test_lines_are_counted_without_what_a_function_says() -> None:
    long = ast.parse('@some\ndef f(\n    a,\n):\n    """Says.\n\n    More.\n    """\n    return a\n').body[0]
    assert isinstance(long, ast.FunctionDef)
    assert lines_of(long) == 4
