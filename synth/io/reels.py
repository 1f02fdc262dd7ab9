"""Frames of a video that are read when they are looked at, so that it may be longer than memory."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import overload

from torch import Tensor

from synth.io.images import read_image
from synth.io.videos import file_frames, frame_names


class Reel(Sequence[Tensor]):
    """What is shown of the frames of a video file, or of a folder of images in the order of their names.

    shown: what of a frame (C, H, W), in [0, 1], is wanted; all of it by default.

    One frame is held at a time. Looked at in order, each frame of a file is decoded once; for an earlier one the file
    is read anew from its start. Raises InputError, before any is looked at, for a file that is missing or cut off or
    whose frames differ in size, and for a folder without images.
    """

    def __init__(self, path: str | Path, shown: Callable[[Tensor], Tensor] = lambda frame: frame) -> None:
        self._path, self._shown = Path(path), shown
        self._names = frame_names(self._path) if self._path.is_dir() else None
        self._count = sum(1 for _ in file_frames(self._path)) if self._names is None else len(self._names)
        self._rest: Iterator[Tensor] = iter(())
        self._frame: Tensor | None = None
        self._taken = self._count + 1  # as if past the end: the first look reads from the start

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Tensor: ...

    @overload
    def __getitem__(self, index: slice) -> list[Tensor]: ...

    def __getitem__(self, index: int | slice) -> Tensor | list[Tensor]:
        if isinstance(index, slice):
            return [self[number] for number in range(self._count)[index]]
        number = range(self._count)[index]
        if self._names is not None:
            return self._shown(read_image(self._names[number]).pixels)
        if self._taken > number + 1:
            self._rest, self._taken = file_frames(self._path, aloud=False), 0
        while self._taken <= number:
            self._frame = next(self._rest)
            self._taken += 1
        assert self._frame is not None
        return self._shown(self._frame)
