"""`kwatra fill VIDEO`: a hole in space and time."""

import argparse
import time
from pathlib import Path

import torch
from torch import Tensor

import synth
from synth import io, texture
from synth.commands.checks import check_distinct, finish, refuse_unused
from synth.commands.progress import progress_line
from synth.commands.wishes import in_frames, read_white
from synth.words import counted, listed


def fill_video(arguments: argparse.Namespace) -> str:
    """Check everything, work, write the video; returns the summary."""
    path = arguments.image
    refuse_unused(arguments, ("extend", "also"), f"is for images but {path} is a video")
    if arguments.hole is None:
        raise synth.InputError(f"{path} is a video; say with --hole what is to be filled, by an image or a video")
    output = arguments.output or Path(f"{path.stem}_fill{io.written_like(path)}")
    io.check_video_output(output, arguments.overwrite)
    if arguments.map is not None:
        io.check_output(arguments.map, None, arguments.overwrite, (".npy",))
        check_distinct([output, arguments.map])
    clip = io.read_video(path)
    hole = _hole(arguments.hole, path, clip.frames)
    exemplars = [_exemplar(each, path, clip) for each in arguments.exemplar]
    mixed = [io.premultiplied(video, clip.kind) for video in (clip.frames, *exemplars)]
    began = time.perf_counter()
    with progress_line(f"{path.name}, {counted(int(hole.sum()), 'pixel')}") as callback:
        filled = texture.fill(
            mixed[0],
            hole,
            exemplar=mixed[1:] or None,
            preset=arguments.preset,
            seed=arguments.seed,
            device=arguments.device,
            callback=callback,
        )
    took = time.perf_counter() - began
    frames = torch.where(hole, io.straight(filled.image, clip.kind), clip.frames)
    extremes = io.extremes_of(clip.kind, [frames])
    writers = {output: io.video_writer(output, frames.unbind(1), clip.rate, clip.kind, extremes)}
    if arguments.map is not None:
        writers[arguments.map] = io.npy_writer(_numbered(filled.source, bool(exemplars)).astype("int32"))
    finish(writers, arguments.overwrite)
    size = f"{counted(hole.shape[0], 'frame')} of {hole.shape[2]}x{hole.shape[1]}"
    many = counted(int(hole.sum()), "pixel")
    return f"wrote {listed(list(writers))}: {size}, {many} filled, seed {arguments.seed}, in {took:.1f} s"


def _numbered(source: "io.Array", elsewhere: bool) -> "io.Array":
    """Where pixels come from, in the files' numbers: 0 is the video itself, from 1 on the exemplars."""
    import numpy as np

    if not elsewhere:
        return source
    own = np.indices((1, *source.shape[1:]))[:, 0]
    return np.where(source[:1] < 0, own, source + np.array([1, 0, 0, 0])[:, None, None, None])


def _hole(mask: Path, video: Path, frames: Tensor) -> Tensor:
    """Where the video (C, T, H, W) is to be filled, boolean (T, H, W): an image's mask is that of every frame."""
    white = read_white(mask, True)
    hole = in_frames(white[None], frames.shape[1])[0]
    if hole.shape != frames.shape[1:]:
        own = _length(white) if white.ndim == 3 else f"{white.shape[1]}x{white.shape[0]}"
        raise synth.InputError(
            f"{mask} is {own} but {video} {_length(frames[0])}; a hole's mask has its video's size, and its "
            "length where it is a video"
        )
    if not bool(hole.any()):
        raise synth.InputError(f"{mask} is black everywhere; it is white where {video} is to be filled")
    return hole


def _exemplar(path: Path, video: Path, clip: "io.Clip") -> Tensor:
    """The frames of a video to fill from."""
    if not io.is_video(path):
        raise synth.InputError(f"{path} is an image but {video} a video; fill it from videos")
    own = io.read_video(path)
    if own.kind != clip.kind:
        raise synth.InputError(f"{path} holds {own.kind} but {video} {clip.kind}; save both alike")
    return own.frames


def _length(frames: Tensor) -> str:
    return f"{counted(frames.shape[0], 'frame')} of {frames.shape[2]}x{frames.shape[1]}"
