"""What is refused before any work, in every command alike, and how a command ends."""

import argparse
import os
import shutil
import signal
import threading
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io

if TYPE_CHECKING:
    from synth.io import Writer

WRITTEN: "list[Path]" = []
"""The files that `finish` wrote, for who wants to know what a run made."""

_MOST_SIDE, _MOST_PIXELS = 2**16, 2**28


def set_up(arguments: argparse.Namespace) -> None:
    """Set the number of threads; InputError for a device that is not there."""
    import torch

    if getattr(arguments, "device", "cpu") == "cuda" and not torch.cuda.is_available():
        raise synth.InputError("--device is cuda but there is no CUDA device here; use cpu")
    if arguments.threads is not None:
        import faiss

        torch.set_num_threads(arguments.threads)
        faiss.omp_set_num_threads(arguments.threads)


def refuse_unused(arguments: argparse.Namespace, names: Iterable[str], reason: str) -> None:
    """Refuse options that this run would ignore. Their default is None, False or [].

    `reason` follows the option's name: "is for videos but a.png is an image".
    """
    for name in names:
        value = getattr(arguments, name)
        if value is not None and value is not False and value != []:
            raise synth.InputError(f"--{name.replace('_', '-')} {reason}; leave it out")


def check_size(shape: tuple[int, int], frames: int = 1) -> None:
    """Refuse a size (H, W) that nobody has the memory for, of so many frames at once."""
    height, width = shape
    if max(height, width) > _MOST_SIDE or height * width * frames > _MOST_PIXELS:
        each = "" if frames == 1 else f" for {frames} frames"
        raise synth.InputError(
            f"a size of {width}x{height}{each} is too large; ask for at most {_MOST_SIDE} a side and 2^28 pixels in all"
        )


def check_memory(needed: int, what: str, cure: str) -> None:
    """Refuse what would need more bytes than this machine's memory has."""
    if not hasattr(os, "sysconf"):
        return
    here = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if needed > here:
        raise synth.InputError(
            f"{what} would need {_gigabytes(needed)} of memory and this machine has {_gigabytes(here)}; {cure}"
        )


def check_disk(needed: int, folder: Path, what: str, cure: str) -> None:
    """Refuse what would need more bytes than are free on the disk of a folder."""
    free = shutil.disk_usage(folder).free
    if needed > free:
        raise synth.InputError(
            f"{what} would need {_gigabytes(needed)} on the disk of {folder} and {_gigabytes(free)} are free; {cure}"
        )


def check_distinct(paths: Sequence[Path]) -> None:
    """Refuse outputs of which one would replace another, or stand within it."""
    targets = [path.resolve() for path in paths]
    for path, target in zip(paths, targets, strict=True):
        if targets.count(target) > 1 or any(target in other.parents for other in targets):
            raise synth.InputError(f"{path} would be written twice; give every output a name of its own")


def finish(writers: "Mapping[Path, Writer]", overwrite: bool, more: bool = False) -> None:
    """Write a command's outputs, its last step: once they move to their places, Ctrl-C comes too late.

    overwrite: whether they replace files that are there; else InputError, also for those that came to be since the
    command began. more: whether there is more to do after them, which Ctrl-C ends as before.
    """
    ours, before = threading.current_thread() is threading.main_thread(), signal.getsignal(signal.SIGINT)
    with io.staged(writers, overwrite) as put:
        if ours:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        put()
    WRITTEN.extend(path.absolute() for path in writers)
    if ours and more:
        signal.signal(signal.SIGINT, before)


def _gigabytes(count: int) -> str:
    return f"{count / 1e9:,.1f} GB"
