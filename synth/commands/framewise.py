"""Frames that are kept one by one in a folder; a video is made of them when all are there.

The folder of a video stands beside it as OUT.frames and goes when the video is whole.
"""

import argparse
import hashlib
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io
from synth.commands.checks import WRITTEN, check_disk, check_distinct, finish, refuse_unused
from synth.words import counted, listed

if TYPE_CHECKING:
    from torch import Tensor

    import flow
    from synth.io import FramesFolder, Kind

Report = Callable[[str, float], None]


@dataclass(frozen=True)
class Track:
    """Frames of one kind: a video file or a folder `output`; extremes: what is black and white in a video."""

    output: Path
    kind: "Kind"
    extremes: tuple[float, float]

    @property
    def video(self) -> bool:
        """Whether the frames become a video in the end."""
        return self.output.suffix.lower() in io.VIDEO_SUFFIXES

    def folder(self, settings: Mapping[str, str]) -> "FramesFolder":
        """Where frames are kept."""
        place = self.output.with_name(f"{self.output.name}.frames") if self.video else self.output
        return io.FramesFolder(place, self.kind, settings)


@dataclass(frozen=True)
class Framewise:
    """A run that makes `total` frames of `shape` (H, W), and what decides how they look: `settings`, by name.

    tracks: what is made of each frame, the picture first, then maps; all videos, or all folders. rate: frames a second
    of a video, where the arguments ask for no other. what: what is made, in words.
    """

    arguments: argparse.Namespace
    tracks: Sequence[Track]
    total: int
    shape: tuple[int, int]
    settings: Mapping[str, str]
    rate: float
    what: str

    @property
    def output(self) -> Path:
        """Where the pictures go."""
        return self.tracks[0].output

    @property
    def video(self) -> bool:
        """Whether the frames become a video in the end."""
        return self.tracks[0].video

    @property
    def folder(self) -> "FramesFolder":
        """Where the pictures are kept."""
        return self.tracks[0].folder(self.settings)

    @property
    def _beside(self) -> "list[FramesFolder]":
        """Where the frames of maps are kept."""
        return [track.folder(self.settings) for track in self.tracks[1:]]

    def checked(self) -> "flow.State | None":
        """Refuse what could not be written; returns the state to go on after, if so asked and there is one."""
        resume, overwrite, folder = self.arguments.resume, self.arguments.overwrite, self.folder
        if not self.video:
            refuse_unused(self.arguments, ["fps"], f"is for video files but {self.output} is to be a folder of frames")
        if resume and self.video and self.output.exists() and not folder.path.exists():
            raise synth.InputError(f"{self.output} is whole, there is nothing to resume; make it anew with --overwrite")
        check_distinct([track.output for track in self.tracks])
        for track in self.tracks:
            if not track.output.is_dir() or self.video:
                io.check_video_output(track.output, overwrite or not self.video)
            track.folder(self.settings).check(overwrite or resume)
        state = folder.state() if resume else None
        done = 0 if state is None else state.number + 1
        for beside in self._beside if done else ():
            last = beside.state()
            if last is None or last.number + 1 < done:
                raise synth.InputError(
                    f"{beside.path} has fewer frames than {folder.path}; begin anew with --overwrite"
                )
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
        return height * width * sum(track.kind.bytes_per_pixel for track in self.tracks) // 4

    def run(self, frames: "Iterator[tuple[Sequence[Tensor], flow.State]]", done: int, report: Report) -> None:
        """Write the frames, a picture (C, H, W) for each track and a state, of which `done` are there, and the videos.

        A KeyboardInterrupt says what is left.
        """
        folder, begun = self.folder, done > 0
        held, began = ExitStack(), time.perf_counter()
        try:
            if begun:
                self._hold(held, done)
            for number, (pictures, state) in enumerate(frames, done):
                if not begun:
                    self._hold(held, done)
                    begun = True
                self._add(pictures, state)
                rate = (number + 1 - done) / (time.perf_counter() - began)
                report(f"frame {number + 1} of {self.total}, {rate:.1f} frames/s", (number + 1) / self.total)
            self._finish(report)
        except KeyboardInterrupt:
            count = folder.count() if begun else 0
            if not count:
                raise
            raise KeyboardInterrupt(
                f"interrupted with {count} of {self.total} frames whole in {folder.path}; --resume goes on"
            ) from None
        finally:
            held.close()

    def _hold(self, held: ExitStack, done: int) -> None:
        """Keep other runs out of the folders, and make room in these for what follows the frames that are done."""
        for each in (self.folder, *self._beside):
            held.enter_context(each.alone())
            if done:
                each.clear(done - 1)
            else:
                each.begin(self.arguments.overwrite or self.arguments.resume)

    def _add(self, pictures: "Sequence[Tensor]", state: "flow.State") -> None:
        """Write a frame of each track, the pictures last: what counts is their state."""
        import torch

        nothing = torch.empty(0, dtype=torch.float32)
        bare = type(state)(state.number, nothing, nothing, nothing)
        for folder, picture in zip(self._beside, pictures[1:], strict=True):
            folder.add(picture, bare)
        self.folder.add(pictures[0], state)

    def _finish(self, report: Report) -> None:
        """Make the videos of the frames, or let the folders be."""
        if not self.video:
            WRITTEN.extend(track.output.absolute() for track in self.tracks)
            return
        fps = self.arguments.fps or self.rate
        finish({track.output: io.video_writer(track.output, self._frames(track, report), fps, track.kind,
                                              track.extremes)
                for track in self.tracks}, self.arguments.overwrite)  # fmt: skip
        for folder in (self.folder, *self._beside):
            folder.remove()

    def _frames(self, track: Track, report: Report) -> "Iterator[Tensor]":
        """The frames of a track, while it is told how many of them are written."""
        for number, frame in enumerate(track.folder(self.settings).frames(self.total), 1):
            report(f"writing {track.output.name}", number / self.total)
            yield frame

    def summary(self, done: int, took: float) -> str:
        """What the run did in so many seconds, after so many frames that were there."""
        height, width = self.shape
        made = self.total - done
        now = f", {made} of them now," if done else ""
        each = f" ({took / made:.2f} s per frame)" if made else ""
        written = listed([track.output for track in self.tracks])
        return f"wrote {written}: {counted(self.total, 'frame')} of {width}x{height}{now} in {took:.1f} s{each}"


def digest(pixels: "Tensor", kind: "Kind | str") -> str:
    """What tells pixels of a kind, or of what the word says, from others."""
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
