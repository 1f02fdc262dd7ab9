"""The names of outputs, where a person gave none or only a folder, and runs that make one output per file."""

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path

import synth


def output_of(given: Path | None, default: str) -> Path:
    """The file to write: as given; in a folder that was given, or in this one, by its default name.

    What was made of an image from standard input goes to standard output. InputError for a folder that does not exist:
    one that is made by mistake is worse than one that is asked for.
    """
    from synth.io.streams import STREAM  # with torch, which --help needs not

    if given is None:
        return STREAM if default.startswith("-_") else Path(default)
    if not given.suffix and given != STREAM and not given.is_dir():
        raise synth.InputError(f"{given} is no folder that exists; make it first, or name a file, with its ending")
    return given / default if given.is_dir() else given


def one_by_one(arguments: argparse.Namespace) -> Iterator[argparse.Namespace]:
    """The arguments of a run for each of several exemplars; with -o, which must name a folder, into that."""
    output, several = arguments.output, arguments.exemplars
    if output is not None and not output.is_dir() and len(several) > 1:
        raise synth.InputError(f"--each makes a file for each exemplar but {output} is no folder; name one that exists")
    for number, exemplar in enumerate(several, 1):
        yield argparse.Namespace(**{**vars(arguments), "exemplars": [exemplar], "more": number < len(several)})


def for_each(arguments: argparse.Namespace, run: Callable[[argparse.Namespace, bool], str]) -> str:
    """A run for each exemplar; all are checked before the first works. `run`: with whether to work; the summary."""
    names = [exemplar.stem for exemplar in arguments.exemplars]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise synth.InputError(f"two exemplars are called {twice}, and so would their outputs; make them one by one")
    for each in one_by_one(arguments):
        run(each, False)
    return "\n".join(run(each, True) for each in one_by_one(arguments))
