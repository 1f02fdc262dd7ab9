"""Recipes: what a run was asked, of which files, so that it can be done again.

A recipe is a TOML file: the command as it was typed with its seed, the versions it ran with, and hashes (SHA-256) of
all files that it named and wrote. Names in it are relative to `folder`, which is relative to the recipe's own place: a
recipe and its files may be moved together.
"""

import argparse
import hashlib
import json
import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import synth
from synth import io
from synth.commands import checks

FORMAT = "kwatra recipe"
_OUTPUTS = ("-o", "--output", "--map", "--energy", "--progress-images", "--seams", "--picture", "--save-recipe")
"""Options whose files are written; `--map` of no command is read."""


@dataclass(frozen=True)
class Recipe:
    """A command as it was typed, in a folder, with versions, and hashes of inputs and outputs by their names there."""

    command: list[str]
    folder: Path
    versions: Mapping[str, str]
    inputs: Mapping[str, str]
    outputs: Mapping[str, str]

    def text(self, place: Path) -> bytes:
        """The TOML file's bytes, for a file in the folder `place`."""
        lines = [
            "# kwatra run THIS_FILE does it again",
            f"format = {_quoted(FORMAT)}",
            f"command = [{', '.join(map(_quoted, self.command))}]",
            f"folder = {_quoted(os.path.relpath(self.folder, place))}",
        ]
        for title, rows in (("versions", self.versions), ("inputs", self.inputs), ("outputs", self.outputs)):
            lines += ["", f"[{title}]", *(f"{_quoted(name)} = {_quoted(value)}" for name, value in rows.items())]
        return "\n".join([*lines, ""]).encode()


def begun(arguments: argparse.Namespace, typed: Sequence[str]) -> Recipe:
    """The recipe of a run that is about to begin, of the words that were typed; InputError if it could not be saved."""
    io.check_output(arguments.save_recipe, None, arguments.overwrite, (".toml",))
    words = list(_without(typed, "--save-recipe"))
    if "-" in words:
        raise synth.InputError("a recipe cannot say what came or went by -; name files")
    if getattr(arguments, "seed", None) is not None and "--seed" not in arguments.options_given:
        words += ["--seed", str(arguments.seed)]
    checks.WRITTEN.clear()
    return Recipe(words, Path.cwd(), versions(), {name: digest(Path(name)) for name in _named(words)}, {})


def saved(recipe: Recipe, path: Path, overwrite: bool) -> None:
    """Write a recipe when the run is done."""
    outputs = {os.path.relpath(written, recipe.folder): digest(written) for written in checks.WRITTEN}
    whole = Recipe(recipe.command, recipe.folder, recipe.versions, recipe.inputs, outputs)
    io.write_files({path: io.bytes_writer(whole.text(path.absolute().parent))}, overwrite)


def read_recipe(path: Path) -> Recipe:
    """Read a recipe. Raises InputError for a file that is none."""
    with io.reading(path, "a recipe"):
        content = path.read_bytes()
    try:
        table = tomllib.loads(content.decode())
    except ValueError as error:
        raise synth.InputError(f"{path} cannot be read as TOML ({str(error).splitlines()[0]}); check it") from error
    command, folder = table.get("command"), table.get("folder", ".")
    tables = [table.get(name, {}) for name in ("versions", "inputs", "outputs")]
    texts = [command, *([*each, *each.values()] if isinstance(each, dict) else None for each in tables), [folder]]
    if table.get("format") != FORMAT or not command or not all(map(_are_texts, texts)):
        raise synth.InputError(f"{path} is no recipe of kwatra's; --save-recipe writes one")
    return Recipe(command, path.absolute().parent / folder, *tables)


def versions() -> dict[str, str]:
    """What decides bits beside the files and the seed."""
    from importlib.metadata import version

    return {name: version(name) for name in ("kwatra", "torch", "numpy", "faiss-cpu")}


def digest(path: Path) -> str:
    """SHA-256 of a file, or of all names and contents in a folder."""
    found = hashlib.sha256()
    files = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
    for file in files:
        if path.is_dir():
            found.update(f"{file.relative_to(path)}\0".encode("utf-8", "surrogateescape"))
        with file.open("rb") as stream:
            while part := stream.read(1 << 20):
                found.update(part)
    return found.hexdigest()


def _named(words: Sequence[str]) -> Iterator[str]:
    """The files and folders that the words of a command name, but for what it writes."""
    seen = set()
    for word, before in zip(words[1:], words, strict=False):
        option, equals, value = word.partition("=")
        if before in _OUTPUTS or (equals and option in _OUTPUTS):
            continue
        for name in (word, value, *word.split("="), *(part for side in word.split("=") for part in side.split(","))):
            name = name.removeprefix("not:")
            if name and name not in seen and not name.startswith("-") and os.path.exists(name):
                seen.add(name)
                yield name


def _without(words: Sequence[str], option: str) -> Iterator[str]:
    rest = iter(words)
    for word in rest:
        if word == option:
            next(rest, None)
        elif not word.startswith(f"{option}="):
            yield word


def _are_texts(values: object) -> bool:
    return isinstance(values, list) and all(isinstance(value, str) for value in values)


def _quoted(text: str) -> str:
    """A TOML string; JSON's are such."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
