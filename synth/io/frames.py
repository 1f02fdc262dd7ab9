"""A folder of frames that a run writes one by one, and that another run can go on with.

Every frame is a file of its own, written together with the state that the next one follows from and the settings they
were made with. So the folder holds whole frames at any time, and nobody goes on with a folder from other settings.
"""

import io
import json
import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from flow import State
from kwatra.base import InputError
from synth.io.image_formats import Kind, suffixes_for
from synth.io.images import image_writer, read_image, write_files
from synth.io.outputs import check_writable

_STATE = ".state.npz"
_TENSORS = ("source", "inside", "image")
_OURS = re.compile(r"(?:\.\d+\.)?(?:(?P<number>\d{6,})\.(?:png|tif)|\.state\.npz)")
"""The names of what a run writes: frames, the state, and either with a process's number while it is being written."""


@dataclass(frozen=True)
class FramesFolder:
    """A folder `path` of frames 000000.png, 000001.png, ... of one kind; TIFF where PNG cannot hold it.

    settings: by name, all that decides what the frames look like.
    """

    path: Path
    kind: Kind
    settings: Mapping[str, str]

    def check_new(self, overwrite: bool) -> None:
        """Refuse with InputError, before any work, a folder that a new run may not or cannot write to."""
        self._check_place()
        if not self.path.is_dir() or not any(self.path.iterdir()):
            return
        if not (self.path / _STATE).exists() or any(_OURS.fullmatch(file.name) is None for file in self.path.iterdir()):
            raise InputError(f"{self.path} holds other things than an animation's frames; name another folder")
        if not overwrite:
            raise InputError(
                f"{self.path} holds {self.count()} frames; go on with --resume, or begin anew with --overwrite"
            )

    def state(self) -> State:
        """The state of the last whole frame.

        Raises InputError if there is none, it was made with other settings, or frames before it are missing.
        """
        self._check_place()
        if not (self.path / _STATE).is_file():
            raise InputError(f"{self.path} holds no frames to go on with; leave out --resume")
        arrays = self._read()
        other = {**self.settings, **json.loads(str(arrays["settings"]))}
        differing = [name for name, value in other.items() if self.settings.get(name) != value]
        if differing:
            raise InputError(
                f"{self.path} was begun with another {' and another '.join(differing)}; "
                "give the same again, or begin anew with --overwrite"
            )
        state = State(int(arrays["number"]), *(torch.from_numpy(arrays[name]) for name in _TENSORS))
        missing = [number for number in range(state.number + 1) if not self._frame(number).is_file()]
        if missing:
            raise InputError(f"{self.path} lacks {self._frame(missing[0]).name}; begin anew with --overwrite")
        return state

    def count(self) -> int:
        """How many whole frames there are."""
        return int(self._read()["number"]) + 1 if (self.path / _STATE).is_file() else 0

    def clear(self, after: int = -1) -> None:
        """Make the folder if there is none, and remove what runs left in it but for the frames up to `after`."""
        try:
            self.path.mkdir(exist_ok=True)
            for file in sorted(self.path.iterdir(), reverse=True):  # the state last: it says whose frames these are
                name = _OURS.fullmatch(file.name)
                if name is not None and not self._kept(file.name, name["number"], after):
                    file.unlink()
        except OSError as error:
            raise InputError(f"{self.path} cannot be written to ({error.strerror}); choose another") from error

    def add(self, pixels: Tensor, state: State) -> None:
        """Write a frame (C, H, W) and its state; both are there then, or, whatever ends the call, neither counts."""
        frame, stream = self._frame(state.number), io.BytesIO()
        tensors = {name: getattr(state, name).cpu().numpy() for name in _TENSORS}
        np.savez(stream, number=state.number, settings=json.dumps(dict(self.settings)), **tensors)
        data = stream.getvalue()
        write_files({frame: image_writer(frame, pixels, self.kind), self.path / _STATE: lambda to: _write(to, data)})

    def frames(self, count: int) -> Iterator[Tensor]:
        """The first frames (C, H, W), read one by one."""
        return (read_image(self._frame(number)).pixels for number in range(count))

    def remove(self) -> None:
        """Remove the frames, and the folder if nothing else is in it."""
        self.clear()
        if not any(self.path.iterdir()):
            self.path.rmdir()

    def _frame(self, number: int) -> Path:
        ending = ".png" if ".png" in suffixes_for(self.kind) else ".tif"
        return self.path / f"{number:06d}{ending}"

    def _kept(self, name: str, number: str | None, after: int) -> bool:
        if name.startswith("."):
            return name == _STATE and after >= 0
        return number is not None and int(number) <= after

    def _read(self) -> Mapping[str, np.ndarray]:
        try:
            with np.load(self.path / _STATE, allow_pickle=False) as file:
                return {name: file[name] for name in ("number", "settings", *_TENSORS)}
        except Exception as error:  # each kind of damage has its own
            raise InputError(f"{self.path / _STATE} is damaged; begin anew with --overwrite") from error

    def _check_place(self) -> None:
        if self.path.exists() and not self.path.is_dir():
            raise InputError(f"{self.path} is a file; name a folder")
        if not self.path.exists():
            check_writable(self.path, overwrite=False)
        elif not os.access(self.path, os.W_OK):
            raise InputError(f"{self.path} is read-only; choose another folder")


def _write(target: Path, data: bytes) -> None:
    target.write_bytes(data)
