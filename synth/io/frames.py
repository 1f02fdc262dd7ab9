"""A folder of frames that a run writes one by one, and that another run can go on with.

Every frame is a file of its own, written together with the state that the next one follows from and the settings they
were made with. So the folder holds whole frames at any time, and nobody goes on with a folder from other settings. A
state without a frame is there before the first: it says whose folder this is.
"""

import json
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from types import ModuleType

import numpy as np
import torch
from torch import Tensor

from flow import State
from kwatra.base import InputError
from synth.io.images import image_writer, read_image
from synth.io.kinds import Kind, frame_ending
from synth.io.numpy_files import npz_bytes, read_npz
from synth.io.outputs import TEMPORARY, Writer, bytes_writer, check_writable, write_files

fcntl: ModuleType | None
try:
    import fcntl
except ImportError:  # not a Unix
    fcntl = None

_STATE = ".state.npz"
_MAYBE = tuple(field.name for field in fields(State) if field.default is None)
_TENSORS = tuple(field.name for field in fields(State) if field.name not in ("number", *_MAYBE))
_FRAME = re.compile(r"(\d{6,})\.(png|tif)")


@dataclass(frozen=True)
class FramesFolder:
    """A folder `path` of frames 000000.png, 000001.png, ... of one kind; TIFF where PNG cannot hold it.

    settings: by name, all that decides what the frames look like.
    """

    path: Path
    kind: Kind
    settings: Mapping[str, str]

    def check(self, more: bool) -> None:
        """Refuse with InputError, before any work, a folder that a run cannot write to, or must not.

        more: whether it may hold frames already, to go on after or to replace.
        """
        if self._is_begun() and not more and self.count():
            raise InputError(
                f"{self.path} holds frames ({self.count()} of them); go on with --resume, or begin anew with "
                "--overwrite"
            )

    def state(self) -> State | None:
        """The state of the last whole frame; None where there is no frame yet.

        Raises InputError if it was made with other settings, or frames before it are missing.
        """
        if not self._is_begun():
            return None
        arrays = self._read()
        other = {**self.settings, **json.loads(str(arrays["settings"]))}
        differing = [name for name, value in other.items() if self.settings.get(name) != value]
        number = int(arrays["number"])
        if differing and number >= 0:
            raise InputError(
                f"{self.path} was begun with another {' and another '.join(differing)}; "
                "give the same again, or begin anew with --overwrite"
            )
        missing = next((n for n in range(number + 1) if not self._frame(n).is_file()), None)
        if missing is not None:
            raise InputError(f"{self.path} lacks {self._frame(missing).name}; begin anew with --overwrite")
        if number < 0:
            return None
        tensors = {name: torch.from_numpy(arrays[name]) for name in (*_TENSORS, *_MAYBE) if name in arrays}
        return State(number, **tensors)

    def count(self) -> int:
        """How many whole frames there are."""
        return int(self._read()["number"]) + 1 if (self.path / _STATE).is_file() else 0

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Within it no other run writes into the folder, which is made if there is none; InputError where one does.

        The system lets go of it when the process ends, however that does. Where it knows no such thing, runs may mix.
        """
        try:
            self.path.mkdir(exist_ok=True)
        except OSError as error:
            raise InputError(f"{self.path} cannot be made ({error.strerror}); choose another") from error
        if fcntl is None:
            yield
            return
        handle = os.open(self.path, os.O_RDONLY)
        try:
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise InputError(
                    f"{self.path} is being written by another run; wait for its end, or name another folder"
                ) from None
            except OSError:  # a file system without locks
                pass
            yield
        finally:
            os.close(handle)

    def begin(self, more: bool) -> None:
        """Empty the folder of what other runs left in it, if it may hold frames; else refuse it as `check` does."""
        self.check(more)
        write_files({self.path / _STATE: self._state_writer(-1, {})}, overwrite=True)
        self.clear(-1)

    def clear(self, after: int) -> None:
        """Remove what runs left in the folder but for the frames up to `after` and their state."""
        try:
            for file in self.path.iterdir():
                frame = _FRAME.fullmatch(file.name)
                if TEMPORARY.fullmatch(file.name) or (frame is not None and int(frame[1]) > after):
                    file.unlink()
        except OSError as error:
            raise InputError(f"{self.path} cannot be written to ({error.strerror}); choose another") from error

    def add(self, pixels: Tensor, state: State) -> None:
        """Write a frame (C, H, W) and its state; both are there then, or, whatever ends the call, neither counts."""
        frame, given = self._frame(state.number), {name: getattr(state, name) for name in (*_TENSORS, *_MAYBE)}
        tensors = {name: tensor.cpu().numpy() for name, tensor in given.items() if tensor is not None}
        states = self._state_writer(state.number, tensors)
        write_files({frame: image_writer(frame, pixels, self.kind), self.path / _STATE: states}, overwrite=True)

    def frames(self, stop: int, first: int = 0) -> Iterator[Tensor]:
        """The frames (C, H, W) from first to stop - 1, read one by one."""
        return (read_image(self._frame(number)).pixels for number in range(first, stop))

    def remove(self) -> None:
        """Remove the frames, and the folder if nothing else is in it."""
        self.clear(-1)
        (self.path / _STATE).unlink(missing_ok=True)
        if not any(self.path.iterdir()):
            self.path.rmdir()

    def _frame(self, number: int) -> Path:
        return self.path / f"{number:06d}{frame_ending(self.kind)}"

    def _state_writer(self, number: int, tensors: Mapping[str, np.ndarray]) -> Writer:
        settings = np.array(json.dumps(dict(self.settings)))
        arrays = {"number": np.array(number), "settings": settings, **tensors}
        return bytes_writer(npz_bytes(arrays, compressed=False))

    def _read(self) -> Mapping[str, np.ndarray]:
        try:
            arrays = read_npz(self.path / _STATE)
            wanted = ("number", "settings", *(_TENSORS if int(arrays["number"]) >= 0 else ()))
            return {name: arrays[name] for name in wanted} | {name: arrays[name] for name in _MAYBE if name in arrays}
        except (InputError, KeyError, ValueError, TypeError, OSError) as error:
            raise InputError(f"{self.path / _STATE} is damaged; begin anew with --overwrite") from error

    def _is_begun(self) -> bool:
        """Whether a run began here; InputError for a place that is no run's, or that cannot be written to."""
        if not self.path.exists():
            check_writable(self.path, overwrite=False)
            return False
        if not self.path.is_dir():
            raise InputError(f"{self.path} is a file; name a folder")
        if not os.access(self.path, os.W_OK):
            raise InputError(f"{self.path} is read-only; choose another folder")
        left = [file.name for file in self.path.iterdir() if not TEMPORARY.fullmatch(file.name)]
        begun = _STATE in left
        if any(name != _STATE and not (begun and _FRAME.fullmatch(name)) for name in left):
            raise InputError(f"{self.path} holds other things than an animation's frames; name another folder")
        return begun
