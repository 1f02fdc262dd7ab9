"""`kwatra run`: a run done again from its recipe, of the same files."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth.commands.parsing import Subparsers, file
from synth.saying import note
from synth.words import listed

if TYPE_CHECKING:
    from synth.commands.recipes import Recipe

LOADS = ("synth.io.images",)

_EPILOG = """examples:
  kwatra synth brick.png --size 512x512 --seed 3 --save-recipe brick.toml
  kwatra run brick.toml -o again.png
"""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "run",
        help="do again what a recipe says",
        description="Do again what was done when a recipe was saved with --save-recipe, if its files are the same.",
        epilog=_EPILOG,
    )
    parser.add_argument("recipe", type=file, metavar="RECIPE", help="the .toml file")
    parser.add_argument(
        "-o", "--output", type=file, metavar="OUT", help="write it here (default: where it was written)"
    )
    parser.add_argument("--overwrite", action="store_true", help="replace files that exist")
    parser.add_argument("--changed", action="store_true", help="also if its files have changed since then")


def run(arguments: argparse.Namespace) -> str:
    """Check the files, then do what the recipe says; returns its summary."""
    from synth.cli import perform
    from synth.commands import checks
    from synth.commands.recipes import digest, read_recipe

    recipe = read_recipe(arguments.recipe)
    if recipe.command[0] == "run":
        raise synth.InputError(f"{arguments.recipe} runs a recipe itself; run that one")
    if not recipe.folder.is_dir():
        raise synth.InputError(f"{recipe.folder}, where {arguments.recipe} is to be run, does not exist; make it first")
    before = Path.cwd()
    words = [word for word in recipe.command if word != "--overwrite"]  # that was asked then, of the files of then
    if arguments.output is not None:
        words = [*_without_output(words), "-o", str(arguments.output.absolute())]
    if arguments.overwrite:
        words.append("--overwrite")
    os.chdir(recipe.folder)
    try:
        _check(recipe, arguments)
        checks.WRITTEN.clear()
        summary = perform(words)
        now = [digest(path) for path in checks.WRITTEN]
    finally:
        os.chdir(before)
    if not recipe.outputs:
        return summary
    same = now == list(recipe.outputs.values())
    return f"{summary}\n{'the same bits as then' if same else 'not the same bits as then'}"


def _check(recipe: "Recipe", arguments: argparse.Namespace) -> None:
    """Refuse files that are not what they were; other versions are told of."""
    from synth.commands.recipes import digest, versions

    changed = []
    for name, value in recipe.inputs.items():
        if not os.path.exists(name):
            raise synth.InputError(f"{name}, which {arguments.recipe} was saved with, is not in {recipe.folder}; "
                                   "put it there")  # fmt: skip
        if digest(Path(name)) != value:
            changed.append(name)
    if changed and not arguments.changed:
        raise synth.InputError(f"{listed(changed)} changed since {arguments.recipe} was saved; to run it all the same "
                               "give --changed")  # fmt: skip
    now = versions()
    other = [f"{name} {value} then, {now[name]} now" for name, value in recipe.versions.items()
             if name in now and now[name] != value]  # fmt: skip
    if other:
        note(f"other versions may make other bits: {'; '.join(other)}")


def _without_output(words: list[str]) -> list[str]:
    kept, skip = [], False
    for word in words:
        if skip or word.startswith("--output=") or (word.startswith("-o") and word != "-o"):
            skip = False
        elif word in ("-o", "--output"):
            skip = True
        else:
            kept.append(word)
    return kept
