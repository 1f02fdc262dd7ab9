"""The house's law: imports point synth -> flow -> kwatra, never back, and the engine knows no files, plots or CLI."""

import ast
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from itertools import permutations
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
ALLOWED = {"kwatra": {"kwatra"}, "flow": {"flow", "kwatra"}, "synth": {"synth", "flow", "kwatra"}}
NOT_IN_THE_ENGINE = {
    "argparse", "av", "click", "csv", "cv2", "glob", "imagecodecs", "imageio", "io", "json", "matplotlib", "OpenEXR",
    "pathlib", "PIL", "plotly", "rich", "seaborn", "shutil", "tempfile", "tifffile", "typer", "tyro",
}  # fmt: skip


def imported(source: str) -> Iterator[tuple[int, str]]:
    """(line, full module name) of every import in a module, wherever it stands."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.lineno, node.module if node.level == 0 and node.module else "." * node.level
            yield from ((node.lineno, f"{node.module}.{alias.name}") for alias in node.names)


@cache
def imports_of(path: Path) -> list[tuple[int, str]]:
    return list(imported(path.read_text()))


def modules(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


@pytest.mark.parametrize("package", ALLOWED)
def test_imports_point_one_way(package: str) -> None:
    assert modules(package)
    for path in modules(package):
        for line, name in imports_of(path):
            top = name.split(".")[0]
            assert top not in ALLOWED.keys() - ALLOWED[package], f"{path}:{line} imports {name}"


def test_the_engine_knows_no_files_plots_or_command_line() -> None:
    for path in modules("kwatra"):
        for line, name in imports_of(path):
            assert name.split(".")[0] not in NOT_IN_THE_ENGINE, f"{path}:{line} imports {name}"
            assert not name.startswith("skimage.io"), f"{path}:{line} imports {name}"


def test_motion_knows_no_files() -> None:
    for path in modules("flow"):
        for line, name in imports_of(path):
            # arrows are drawn by PIL, in memory
            assert name.split(".")[0] not in NOT_IN_THE_ENGINE - {"PIL"}, f"{path}:{line} imports {name}"


@pytest.mark.parametrize(
    ("room", "stranger"),
    [
        *[("synth/io", f"synth.{other}") for other in ("texture", "quilting", "metamorphosis", "commands")],
        *[(f"synth/{program}", "synth.commands") for program in ("texture", "quilting", "metamorphosis")],
        *[(f"synth/metamorphosis/{one}", f"synth.metamorphosis.{other}")
          for one, other in permutations(("blend", "optimal_control", "patches", "patterns", "textons"), 2)],
    ],
)  # fmt: skip
def test_commands_use_programs_and_programs_files_and_no_method_another(room: str, stranger: str) -> None:
    assert modules(room)
    for path in modules(room):
        for line, name in imports_of(path):
            assert not f"{name}.".startswith(f"{stranger}."), f"{path}:{line} imports {name}"


def test_nothing_imports_relatively() -> None:
    for package in ALLOWED:
        for path in modules(package):
            assert not [line for line, name in imports_of(path) if name.startswith(".")], path


def test_no_modules_import_each_other() -> None:
    paths = [path for package in ALLOWED for path in modules(package)]
    named = {".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path for path in paths}
    needs = {name: set[str]() for name in named}
    for name, path in named.items():
        known = [(line, other) for line, other in imports_of(path) if other in named]
        within = {(line, other.rpartition(".")[0]) for line, other in known}  # of a package only the modules in it
        needs[name] = {other for line, other in known if (line, other) not in within}
    order = list(TopologicalSorter(needs).static_order())  # raises CycleError, which names those in a circle
    assert (
        order.index("kwatra.base.errors") < order.index("kwatra.loop.optimize") < order.index("flow.animation.sequence")
    )


def test_imports_are_found_wherever_they_stand() -> None:
    source = "import a.b\nif True:\n    from c import d\ndef f():\n    import e as g\n"
    assert [name for _, name in imported(source)] == ["a.b", "c", "c.d", "e"]
