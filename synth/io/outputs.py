"""Files written whole or not at all.

Nothing is written in place: every file is made beside its target, forced to disk, and moved there when all files of
the call are complete. If one cannot be moved, the others are moved back. What may not be replaced is not, also where it
came to be only while the files were made: these then get names of their own beside it.
"""

import errno
import itertools
import os
import re
import secrets
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from kwatra.base import InputError
from synth.io.streams import STREAM, to_standard_output

Writer = Callable[[Path], None]

TEMPORARY = re.compile(r"\.kwatra-[0-9a-f]{16}(\.\w{1,8})?")
"""The names of files that are being written."""


class _Taken(Exception):
    """A name came to be another's while files were made for it."""


def check_writable(path: Path, overwrite: bool) -> None:
    """Refuse with InputError, before any work, a file that could not be written, or must not be replaced."""
    with _told(path):
        if path.is_dir():
            raise InputError(f"{path} is a folder; name a file")
        check_place(path, overwrite)


def check_place(path: Path, overwrite: bool) -> None:
    """Refuse what must not be replaced, or stands where nothing can be written."""
    if path.exists() and not overwrite:
        raise InputError(f"{path} exists; name another file or allow it with --overwrite")
    folder = path.absolute().parent
    if not folder.is_dir():
        raise InputError(f"{path} cannot be written because the folder {path.parent} does not exist; make it first")
    if not os.access(folder, os.W_OK):
        raise InputError(f"{path} cannot be written because the folder {path.parent} is read-only; choose another")


def bytes_writer(data: bytes) -> Writer:
    """What writes these bytes."""

    def write(target: Path) -> None:
        target.write_bytes(data)

    return write


def write_files(writers: Mapping[Path, Writer], overwrite: bool) -> None:
    """Write several files or folders, all or none: each writer gets the path of a temporary one beside its target.

    Raises InputError when one cannot be written, or is there and `overwrite` is not set; the temporary ones are removed
    then, whatever ends the call.
    """
    with staged(writers, overwrite) as put:
        put()


@contextmanager
def staged(writers: Mapping[Path, Writer], overwrite: bool) -> Iterator[Callable[[], None]]:
    """The files, complete beside their targets, and what moves them there; see `write_files`."""
    made: dict[Path, Path] = {}
    try:
        for path, writer in writers.items():
            target = STREAM if path == STREAM else path.resolve()
            made[target] = _beside(target) if target != STREAM else _somewhere()
            with _told(path):
                writer(made[target])
                if made[target].is_file():
                    _force_to_disk(made[target])
        yield lambda: _put(made, overwrite)
    finally:
        for temporary in made.values():
            _remove(temporary)


def _put(made: Mapping[Path, Path], overwrite: bool) -> None:
    """Move all to their targets; if one cannot be, whatever was there is back in its place.

    Raises InputError, and moves all to names beside these, where one came to be while the files were made.
    """
    aside: dict[Path, Path] = {}
    made = dict(sorted(made.items(), key=lambda pair: pair[0] == STREAM))  # what is sent cannot be taken back
    placed: list[Path] = []
    try:
        for number, (target, temporary) in enumerate(made.items(), 1):
            with _told(target):
                if target == STREAM:
                    to_standard_output(temporary)
                    continue
                if overwrite and (target.is_dir() or (number < len(made) and target.exists())):
                    aside[target] = _set_aside(target)
                (os.replace if overwrite else _claim)(temporary, target)
                placed.append(target)
    except BaseException as error:
        for target in placed:
            if target not in aside:
                _take_back(target, made[target])
        for target, old in aside.items():
            _remove_folder(target)
            os.replace(old, target)
            _remove(old)  # where both are one file, nothing was moved
        if isinstance(error, _Taken):
            raise InputError(f"{error} came to be while this ran; what was made is {_kept(made)}") from None
        raise
    for old in aside.values():
        _remove(old)


def _claim(temporary: Path, target: Path) -> None:
    """Move to a name that nothing has; _Taken where something came to have it, which stays as it is."""
    try:
        if temporary.is_dir():
            target.mkdir()
        else:
            try:
                os.link(temporary, target)
                return
            except FileExistsError:
                raise
            except OSError:  # a file system without links
                target.touch(exist_ok=False)
    except FileExistsError:
        raise _Taken(target) from None
    os.replace(temporary, target)  # ours, and empty


def _take_back(target: Path, temporary: Path) -> None:
    """Undo a move to a name that nothing had."""
    if temporary.exists():  # the same file
        _remove(target)
    else:
        os.replace(target, temporary)


def _kept(made: Mapping[Path, Path]) -> str:
    """Move all to names like their targets', with the first number that is free for each of them; said in words."""
    files = [target for target in made if target != STREAM]
    for number in itertools.count(2):
        names = {target: target.with_name(f"{target.stem}-{number}{target.suffix}") for target in files}
        if not any(name.exists() for name in names.values()):
            break
    for target, name in names.items():
        with _told(name):
            _claim(made[target], name)
    return " and ".join(map(str, names.values()))


def _set_aside(target: Path) -> Path:
    """Keep what a target holds under another name; a file stays where it is, so that it is never missing."""
    old = _beside(target)
    if target.is_dir():
        target.rename(old)
        return old
    try:
        os.link(target, old)
    except OSError:  # a file system without links
        shutil.copy2(target, old)
    return old


def _beside(target: Path) -> Path:
    """A name in the target's folder that no other process or host has."""
    suffix = target.suffix if re.fullmatch(r"\.\w{1,8}", target.suffix, re.ASCII) else ""
    return target.with_name(f".kwatra-{secrets.token_hex(8)}{suffix}")


def _somewhere() -> Path:
    """A file that is no other's."""
    handle, name = tempfile.mkstemp(prefix="kwatra-")
    os.close(handle)
    return Path(name)


def _remove(path: Path) -> None:
    _remove_folder(path)
    path.unlink(missing_ok=True)


def _remove_folder(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """Say an OSError in one sentence that names the file; but that whoever read a stream has gone is no fault."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            raise InputError(f"{path} was not written because the disk is full; free some space") from error
        raise InputError(f"{path} was not written ({error.strerror or error}); choose another place") from error


def _force_to_disk(path: Path) -> None:
    with path.open("rb+") as file:
        os.fsync(file.fileno())
