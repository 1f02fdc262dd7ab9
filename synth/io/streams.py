"""`-` in the place of a file's name: an image from standard input, or to standard output."""

import atexit
import os
import shutil
import sys
import tempfile
from functools import lru_cache
from pathlib import Path

from kwatra.base import InputError

STREAM = Path("-")
"""What stands for standard input, or output."""


@lru_cache(maxsize=1)
def standard_input() -> Path:
    """All of standard input, as a file that goes when the process ends; InputError where there is none."""
    stream = sys.stdin.buffer if sys.stdin is not None and hasattr(sys.stdin, "buffer") else None
    if stream is None or sys.stdin.isatty():
        raise InputError("- stands for an image on standard input, but there is none; write ... | kwatra ...")
    handle, name = tempfile.mkstemp(prefix="standard-input-")
    atexit.register(Path(name).unlink, missing_ok=True)
    with os.fdopen(handle, "wb") as file:
        shutil.copyfileobj(stream, file)
    return Path(name)


def check_standard_output() -> None:
    """Refuse to write an image where a person would see its bytes."""
    if sys.stdout is None or sys.stdout.closed or sys.stdout.isatty():
        raise InputError("-o - writes the image to standard output, which is a terminal; redirect it, or name a file")


def to_standard_output(path: Path) -> None:
    """Copy a file there."""
    sys.stdout.flush()
    with path.open("rb") as file:
        shutil.copyfileobj(file, sys.stdout.buffer)
    sys.stdout.buffer.flush()
