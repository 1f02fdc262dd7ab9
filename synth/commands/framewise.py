"""Frames that are kept one by one in a folder; a video is made of them when all are there.

The folder of a video stands beside it as OUT.frames and goes when the video is whole.
"""

import argparse
import hashlib
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io
from synth.commands.checks import check_disk, finish, refuse_unused
from synth.words import counted

if TYPE_CHECKING:
    from torch import Tensor

    import flow
    from synth.io import FramesFolder, Kind

Report = Callable[[str, float], None]


@dataclass(frozen=True)
class Framewise:
    """A run that makes `total` frames of `shape` (H, W) and kind, and what decides how they look: `settings`, by name.

    rate: frames a second of a video, where the arguments ask for no other. extremes: what is black and white in it.
    what: what is made, in words.
    """

    arguments: argparse.Namespace
    output: Path
    total: int
    shape: tuple[int, int]
    kind: "Kind"
    settings: Mapping[str, str]
    rate: float
    extremes: tuple[float, float]
    what: str

    @property
    def video(self) -> bool:
        """Whether the frames become a video in the end."""
        return self.output.suffix.lower() in io.VIDEO_SUFFIXES

    @property
    def folder(self) -> "FramesFolder":
        """Where frames are kept."""
        place = self.output.with_name(f"{self.output.name}.frames") if self.video else self.output
        return io.FramesFolder(place, self.kind, self.settings)

    def checked(self) -> "flow.State | None":
        """Refuse what could not be written; returns the state to go on after, if so asked and there is one."""
        resume, overwrite, folder = self.arguments.resume, self.arguments.overwrite, self.folder
        if not self.video:
            refuse_unused(self.arguments, ["fps"], f"is for video files but {self.output} is to be a folder of frames")
        if not self.output.is_dir() or self.video:
            if resume and self.video and self.output.exists() and not folder.path.exists():
                raise synth.InputError(
                    f"{self.output} is whole, there is nothing to resume; make it anew with --overwrite"
                )
            io.check_video_output(self.output, overwrite or not self.video)
        folder.check(overwrite or resume)
        state = folder.state() if resume else None
        done = 0 if state is None else state.number + 1
        if done > self.total:
            raise synth.InputError(
                f"{folder.path} has {counted(done, 'frame')} already, more than the {self.total} asked for; "
                f"give --frames {done} or more"
            )
        length = f"{self.what} of {counted(self.total, 'frame')}"
        check_disk((self.total - done) * self._least_bytes(), folder.path.absolute().parent, length, "ask for fewer")
        return state

    def _least_bytes(self) -> int:
        """What a frame takes at least on a disk: textures compress to about half, so a quarter."""
        height, width = self.shape
        return height * width * self.kind.bytes_per_pixel // 4

    def run(self, frames: "Iterator[tuple[Tensor, flow.State]]", done: int, report: Report) -> None:
        """Write the frames (C, H, W), each with its state, of which `done` are there, and the video.

        A KeyboardInterrupt says what is left.
        """
        folder, begun = self.folder, done > 0
        if begun:
            folder.clear(done - 1)
        began = time.perf_counter()
        try:
            for number, (pixels, state) in enumerate(frames, done):
                if not begun:
                    folder.begin()
                    begun = True
                folder.add(pixels, state)
                rate = (number + 1 - done) / (time.perf_counter() - began)
                report(f"frame {number + 1} of {self.total}, {rate:.1f} frames/s", (number + 1) / self.total)
            if self.video:
                fps = self.arguments.fps or self.rate
                finish({self.output: io.video_writer(self.output, self._shown(report), fps, self.kind)})
                folder.remove()
        except KeyboardInterrupt:
            count = folder.count() if begun else 0
            if not count:
                raise
            raise KeyboardInterrupt(
                f"interrupted with {count} of {self.total} frames whole in {folder.path}; --resume goes on"
            ) from None

    def _shown(self, report: Report) -> "Iterator[Tensor]":
        """The frames of a video, from black 0 to white 1."""
        low, high = self.extremes
        for number, frame in enumerate(self.folder.frames(self.total), 1):
            report(f"writing {self.output.name}", number / self.total)
            yield (frame - low) / ((high - low) or 1.0)

    def summary(self, done: int, took: float) -> str:
        """What the run did in so many seconds, after so many frames that were there."""
        height, width = self.shape
        made = self.total - done
        now = f", {made} of them now," if done else ""
        each = f" ({took / made:.2f} s per frame)" if made else ""
        return f"wrote {self.output}: {counted(self.total, 'frame')} of {width}x{height}{now} in {took:.1f} s{each}"


def digest(pixels: "Tensor", kind: "Kind") -> str:
    """What tells pixels of a kind from others."""
    import numpy as np

    values = np.ascontiguousarray(pixels.numpy())
    return hashlib.sha256(f"{kind} {values.shape}".encode() + values.tobytes()).hexdigest()


def versions() -> dict[str, str]:
    """The versions that decide what frames look like."""
    import torch

    try:
        own = version("kwatra")
    except PackageNotFoundError:
        own = "not installed"
    return {"version of kwatra": own, "version of torch": torch.__version__}
