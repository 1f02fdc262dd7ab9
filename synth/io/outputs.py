"""Files written whole or not at all.

Nothing is written in place: every file is made beside its target, forced to disk, and moved there when all files of
the call are complete.
"""

import errno
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from kwatra.base import InputError

Writer = Callable[[Path], None]


def check_writable(path: Path, overwrite: bool) -> None:
    """Refuse with InputError, before any work, a file that could not be written, or must not be replaced."""
    if path.is_dir():
        raise InputError(f"{path} is a folder; name a file")
    if path.exists() and not overwrite:
        raise InputError(f"{path} exists; name another file or allow it with --overwrite (overwrite=True)")
    if not path.parent.is_dir():
        raise InputError(f"{path} cannot be written because the folder {path.parent} does not exist; make it first")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path} cannot be written because the folder {path.parent} is read-only; choose another")


def write_files(writers: Mapping[Path, Writer]) -> None:
    """Write several files or folders, all or none: each writer gets the path of a temporary one beside its target.

    Raises InputError when one cannot be written; the temporary ones are removed then, whatever ends the call.
    """
    temporary: dict[Path, Path] = {}
    try:
        for path, writer in writers.items():
            target = path.resolve()
            temporary[target] = target.with_name(f".{os.getpid()}.{target.name[-200:]}")
            with _told(path):
                writer(temporary[target])
                if temporary[target].is_file():
                    _force_to_disk(temporary[target])
        for target, made in temporary.items():
            with _told(target):
                _put(made, target)
    finally:
        for made in temporary.values():
            _remove(made)


def _put(made: Path, target: Path) -> None:
    """Move a file or folder to where another may be; if that fails the other is back in its place."""
    if not target.is_dir():
        os.replace(made, target)
        return
    old = target.with_name(f".{os.getpid()}.old.{target.name[-200:]}")
    target.rename(old)
    try:
        made.rename(target)
    except OSError:
        old.rename(target)
        raise
    shutil.rmtree(old)


def _remove(made: Path) -> None:
    if made.is_dir():
        shutil.rmtree(made)
    else:
        made.unlink(missing_ok=True)


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """Say an OSError in one sentence that names the file."""
    try:
        yield
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            raise InputError(f"{path} was not written because the disk is full; free some space") from error
        raise InputError(f"{path} was not written ({error.strerror or error}); choose another place") from error


def _force_to_disk(path: Path) -> None:
    with path.open("rb+") as file:
        os.fsync(file.fileno())
