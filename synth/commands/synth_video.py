"""`kwatra synth VIDEO`: frames are kept as they are made, stretch by stretch."""

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import torch
from torch import Tensor

import synth
from synth import io, texture
from synth.commands.checks import check_distinct, check_size, finish, refuse_unused
from synth.commands.framewise import Framewise, Track, digest, versions
from synth.commands.parsing import MOST_FRAMES
from synth.commands.progress import place_of, work_line
from synth.commands.report import ENERGY_SUFFIXES, energy_writer
from synth.commands.video_asked import Asked
from synth.words import counted, listed

if TYPE_CHECKING:
    import flow
    from synth.io import Kind, Writer
    from synth.texture import Synthesis

_STILL = ("apply", "each", "progress_images", "verbose")
_WHOLE = ("also", "map", "energy")
_FPS = 25.0


@dataclass(frozen=True)
class _Clips:
    """The exemplars: frames (C, T, H, W) of one kind, colors multiplied by alpha; rate: frames a second."""

    frames: list[Tensor]
    kind: "Kind"
    rate: float

    @classmethod
    def read(cls, arguments: argparse.Namespace) -> "_Clips":
        """All that the arguments name; InputError for stills. Clips of several kinds are raised to the richest."""
        still = [path for path in arguments.exemplars if not io.is_video(path)]
        if still:
            raise synth.InputError(f"{still[0]} is an image and others are videos; give all of one sort")
        clips = [io.read_video(path, arguments.fps or _FPS) for path in arguments.exemplars]
        kind = io.richest([clip.kind for clip in clips], arguments.exemplars)
        frames = [io.premultiplied(io.as_kind(clip.frames, clip.kind, kind), kind) for clip in clips]
        return cls(frames, kind, clips[0].rate)


def run_video(arguments: argparse.Namespace) -> str:
    """Check everything, work, write everything; returns the summary."""
    source = arguments.exemplars[0]
    refuse_unused(arguments, _STILL, f"is for images but {source} is a video")
    if arguments.tile == "nearest":
        raise synth.InputError("--tile nearest is for images; for videos use --tile, and --size for whole periods")
    clips = _Clips.read(arguments)
    asked = Asked.read(arguments, clips.frames, clips.kind)
    size = _size(arguments, clips, asked)
    asked.check(size)
    asked = asked.through(size[0])
    output = arguments.output or Path(f"{source.stem}_synth{io.written_like(source)}")
    track = Track(output, clips.kind, io.extremes_of(clips.kind, clips.frames))
    job = Framewise(
        arguments, [track], size[0], size[1:], _settings(arguments, clips, asked, size), clips.rate, "a video"
    )  # fmt: skip
    extras = _Extras(arguments, clips, output)
    extras.check()
    after = job.checked()
    done = 0 if after is None else after.number + 1
    if done:
        there = f"{job.folder.path} holds {counted(done, 'frame')} of it"
        refuse_unused(arguments, _WHOLE, f"tells of a whole run but {there} already")
    if done == size[0] and not job.video:
        return f"{output} has its {counted(done, 'frame')} already; there is nothing to do"
    began = time.perf_counter()
    with work_line(f"{source.name} to {size[2]}x{size[1]}") as report:
        job.run(_frames(arguments, clips, asked, size, job, done, extras.add, report), done, _writing(report))
        more = extras.writers()
        finish(more, arguments.overwrite)
    also = f"; also {listed(list(more))}" if more else ""
    return job.summary(done, time.perf_counter() - began) + also


def _writing(report: Callable[[str, float], None]) -> Callable[[str, float], None]:
    """The report of frames being written, without that of each: they come in stretches, which tell more."""
    return lambda what, part: report(what, part) if what.startswith("writing") else None


def _size(arguments: argparse.Namespace, clips: _Clips, asked: Asked) -> tuple[int, int, int]:
    """(frames, height, width): as asked, else as what is given of the output has it, else twice the clip's length."""
    length, *own = clips.frames[0].shape[1:]
    frames = arguments.frames
    if arguments.seconds is not None:
        there = arguments.seconds * (arguments.fps or clips.rate)
        if there > MOST_FRAMES:
            raise synth.InputError(f"{arguments.seconds:g} seconds are more than {MOST_FRAMES} frames; ask for fewer")
        frames = round(there)
        if frames < 1:
            raise synth.InputError(f"{arguments.seconds:g} seconds are less than a frame; ask for more")
    frames, *size = asked.agreed((frames, *(arguments.size or (None, None))))
    height, width = [given or there for given, there in zip(size, own, strict=True)]
    check_size((height, width))
    return frames or 2 * length, height, width


def _settings(arguments: argparse.Namespace, clips: _Clips, asked: Asked, size: tuple[int, int, int]) -> dict[str, str]:
    """All that decides what the frames look like, by names that a user knows."""
    names = ("seed", "preset", "tile", "loop", "stay", "levels", "mirror", "rotate", "scale", "device")
    return {
        "exemplar": " ".join(digest(frames, clips.kind) for frames in clips.frames),
        "--size": f"{size[2]}x{size[1]}",
        "--frames": str(size[0]),
        **{f"--{name}": str(getattr(arguments, name)) for name in names},
        **asked.settings,
        **versions(),
    }


def _frames(
    arguments: argparse.Namespace,
    clips: _Clips,
    asked: Asked,
    size: tuple[int, int, int],
    job: Framewise,
    done: int,
    told: "Callable[[Synthesis[Tensor]], None]",
    report: Callable[[str, float], None],
) -> "Iterator[tuple[tuple[Tensor], flow.State]]":
    """The frames behind those that are done, each with its number as a state."""
    from flow import State

    def shown(first: int, stop: int) -> Tensor:
        frames = job.folder.frames(stop, first)
        return torch.stack([io.premultiplied(frame, clips.kind) for frame in frames], 1)

    nothing, number = torch.empty(0, dtype=torch.float32), done
    made = texture.stretches(
        clips.frames,
        size,
        seed=arguments.seed,
        done=done,
        shown=shown,
        callback=lambda progress: report(place_of(progress), progress.fraction),
        preset=arguments.preset,
        tile=arguments.tile is not None,
        loop=arguments.loop,
        stay=arguments.stay,
        levels=arguments.levels,
        mirror=arguments.mirror,
        rotate=arguments.rotate,
        scale=arguments.scale or (),
        device=arguments.device,
        **asked.options(clips.frames, arguments.device),
    )
    for synthesis in made:
        told(synthesis)
        for frame in synthesis.image.unbind(1):
            kept = asked.wishes.kept(frame, number)
            yield (io.straight(kept, clips.kind),), State(number, nothing, nothing, nothing)
            number += 1


class _Extras:
    """What is told of a whole run beside its frames: maps carried along, where pixels come from, energies."""

    def __init__(self, arguments: argparse.Namespace, clips: _Clips, output: Path) -> None:
        self.arguments, self.clips, self.output = arguments, clips, output
        self.sources: list[Any] = []
        self.turns: list[Any] = []
        self.rows: list[dict[str, object]] = []
        self.maps = dict(self._map(request) for request in arguments.also)

    def _map(self, request: str) -> "tuple[Path, tuple[str, list[Tensor], Kind]]":
        """NAME=VIDEO[,VIDEO] as the output, the name, and the frames (C, T, H, W) of each exemplar's map."""
        name, equals, last = request.partition("=")
        files = [Path(part) for part in last.split(",")] if len(self.clips.frames) > 1 else [Path(last)]
        if not (name and equals and last) or len(files) != len(self.clips.frames):
            raise synth.InputError(f"--also is {request!r}; write NAME=VIDEO, with a video for each exemplar")
        maps = [io.read_video(file) for file in files]
        for file, carried, frames in zip(files, maps, self.clips.frames, strict=True):
            if carried.frames.shape[1:] != frames.shape[1:]:
                raise synth.InputError(
                    f"{file} is {_length(carried.frames)} but its exemplar {_length(frames)}; a map has its exemplar's "
                    "length and size"
                )
        kind = io.richest([carried.kind for carried in maps], files)
        target = self.output.with_name(f"{self.output.stem}_{name}{io.written_like(files[0])}")
        return target, (name, [io.as_kind(carried.frames, carried.kind, kind) for carried in maps], kind)

    def check(self) -> None:
        """Refuse before any work what could not be written after it, or held in memory."""
        asked, overwrite = self.arguments, self.arguments.overwrite
        for target in self.maps:
            io.check_video_output(target, overwrite)
        if asked.map is not None:
            io.check_output(asked.map, None, overwrite, (".npy",))
        if asked.energy is not None:
            io.check_output(asked.energy, None, overwrite, ENERGY_SUFFIXES)
        extra = [path for path in (asked.map, asked.energy) if path is not None]
        check_distinct([self.output, *self.maps, *extra])

    def add(self, synthesis: "Synthesis[Tensor]") -> None:
        """What a stretch tells."""
        if self.maps or self.arguments.map is not None:
            self.sources.append(synthesis.source.astype("int32"))
            self.turns += [] if synthesis.turns is None else [synthesis.turns]
        stretch = len(self.rows) and int(str(self.rows[-1]["stretch"])) + 1
        self.rows += [{"stretch": stretch, **row} for row in synthesis.result.energies]

    def writers(self) -> "dict[Path, Writer]":
        """What writes all that is asked for."""
        import numpy as np

        writers: dict[Path, Writer] = {}
        if self.arguments.energy is not None:
            writers[self.arguments.energy] = energy_writer(self.arguments.energy, self.rows)
        if not self.sources:
            return writers
        source = np.concatenate(self.sources, 1)
        if self.arguments.map is not None:
            writers[self.arguments.map] = io.npy_writer(source)
        turns = np.concatenate(self.turns, 2) if self.turns else None
        for target, (name, maps, kind) in self.maps.items():
            carried = texture.rearranged(name, [frames.movedim(0, -1).numpy() for frames in maps], source, turns)
            frames = torch.from_numpy(carried).movedim(-1, 0).unbind(1)
            rate = self.arguments.fps or self.clips.rate
            writers[target] = io.video_writer(target, frames, rate, kind, io.extremes_of(kind, maps))
        return writers


def _length(frames: Tensor) -> str:
    return f"{counted(frames.shape[1], 'frame')} of {frames.shape[3]}x{frames.shape[2]}"
