"""Video in and out of files: MP4, GIF, WebM and MOV, or a folder of frames; MKV, AVI and others are read, too.

Frames are (C, T, H, W) float32 in [0, 1].

A video is written beside its target and moved there when it is whole; a folder of frames likewise. A folder of PNG
frames keeps every value.
"""

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from kwatra.base import InputError
from synth.io.alpha import premultiplied
from synth.io.alpha_videos import ALPHA_SUFFIXES, check_encoder, frames_with_alpha, has_alpha, save_with_alpha
from synth.io.images import image_writer, read_array, to_pixels
from synth.io.kinds import MOST_PIXELS, RGB, RGBA, Kind, frame_ending
from synth.io.opaque_videos import save_gif, save_mp4
from synth.io.outputs import Writer, check_place, write_files
from synth.io.raising import as_kind, richest
from synth.io.unreadable import reading
from synth.saying import note

VIDEO_SUFFIXES = (".mp4", ".gif", *ALPHA_SUFFIXES)
_READ_SUFFIXES = (*VIDEO_SUFFIXES, ".mkv", ".avi", ".m4v", ".mpg", ".mpeg", ".ts", ".wmv", ".flv", ".ogv", ".3gp")
_FRAME_SUFFIXES = (".png", ".tif", ".tiff", ".jpg", ".jpeg", ".exr", ".webp", ".bmp", ".tga")
_EVEN = 1.5
"""Frames of which one lasts so many times as long as another one are not told apart by rounding of their times."""

_WHOLE = 0.9
"""A file is whole that holds this part of the time that it tells; frames before the first whole one may be missing."""

_COLORS, _WITH_ALPHA = Kind("uint8", RGB), Kind("uint8", RGBA)


@dataclass(frozen=True)
class Clip:
    """A video file's content: frames (C, T, H, W), how many play in a second, and the kind of its frames."""

    frames: Tensor
    rate: float
    kind: Kind


def is_video(path: str | Path) -> bool:
    """Whether a path is a folder or ends like a video file."""
    path = Path(path)
    return path.is_dir() or path.suffix.lower() in _READ_SUFFIXES


def written_like(path: Path) -> str:
    """The ending of a video made of the one at a path: its own, .mp4 if none is written with that, none of a folder."""
    if path.is_dir():
        return ""
    return path.suffix if path.suffix.lower() in VIDEO_SUFFIXES else ".mp4"


def read_video(path: str | Path, rate: float = 25.0) -> Clip:
    """Read a video file or a folder of images in the order of their names; `rate` is a folder's.

    A file's sound, and frames that last differently long, are told of in a line on stderr: neither is kept. Of a folder
    that holds images of several kinds all are raised to the richest (`synth.io.raised`).

    Raises InputError if it is missing, damaged or without frames, or if its frames differ in size; or for a GIF of one
    frame, which is a picture.
    """
    path = Path(path)
    return _read_folder(path, rate) if path.is_dir() else _read_file(path)


def write_video(path: str | Path, frames: Tensor, rate: float, kind: Kind = _COLORS, overwrite: bool = False) -> None:
    """Write frames (C, T, H, W) as .mp4, .gif, .webm or .mov by the ending of `path`, or as a folder of PNG or TIFF.

    The last two and folders keep alpha. Floats are shown from their least value to their largest; a folder keeps them.

    Raises InputError if the target exists and `overwrite` is not set, or cannot be written; it is then as it was.
    """
    check_video_output(path, overwrite)
    writer = video_writer(path, frames.unbind(1), rate, kind, extremes_of(kind, [frames]))
    write_files({Path(path): writer}, overwrite)


def extremes_of(kind: Kind, videos: Iterable[Tensor]) -> tuple[float, float]:
    """What is black and white in a video file: 0 and 1, or of floats the least and largest value of some videos."""
    if not kind.dtype.startswith("f"):
        return 0.0, 1.0
    lows, highs = zip(*((float(video.min()), float(video.max())) for video in videos), strict=True)
    return min(lows), max(highs)


def video_writer(
    path: str | Path,
    frames: Iterable[Tensor],
    rate: float,
    kind: Kind = _COLORS,
    extremes: tuple[float, float] = (0.0, 1.0),
) -> Writer:
    """What writes frames (C, H, W), one by one, in the form that the ending of `path` names: see `write_files`.

    extremes: what is black and white in a file; a folder keeps values. What is transparent is black where a form has no
    alpha.
    """
    suffix, (low, high) = Path(path).suffix.lower(), extremes
    if suffix not in VIDEO_SUFFIXES:
        return lambda target: _save_folder(target, frames, kind)
    shown = ((frame - low) / ((high - low) or 1.0) for frame in frames)
    if suffix in ALPHA_SUFFIXES:
        return lambda target: save_with_alpha(target, _bytes(shown, "A" in kind.channels), rate)
    save = save_mp4 if suffix == ".mp4" else save_gif
    return lambda target: save(target, _bytes(premultiplied(frame, kind) for frame in shown), rate)


def check_video_output(path: str | Path, overwrite: bool) -> None:
    """Refuse, before any work, a file or folder that could not be written."""
    path = Path(path)
    if path.suffix and path.suffix.lower() not in VIDEO_SUFFIXES:
        raise InputError(
            f"{path} has an ending that no video can have; use .mp4, .gif, .webm or .mov, or none for a folder"
        )
    if path.suffix.lower() in ALPHA_SUFFIXES:
        check_encoder(path)
    if path.is_dir() and path.suffix:
        raise InputError(f"{path} is a folder; name a file")
    check_place(path, overwrite)
    if path.is_dir() and any(not _is_frame(p) for p in path.iterdir()):
        raise InputError(f"{path} holds more than frames and is not replaced; name another folder")


def frame_names(path: Path) -> list[Path]:
    """The images of a folder in the order of their names, 2.png before 10.png; InputError if there are none."""
    names = sorted((p for p in path.iterdir() if _is_frame(p)), key=_in_order)
    if not names:
        raise InputError(f"{path} holds no images; give a folder of frames, an .mp4 or a .gif")
    return names


def file_frames(path: Path, aloud: bool = True) -> Iterator[Tensor]:
    """The frames (C, H, W) of a video file, one by one; InputError as for `read_video`, some after the last frame.

    aloud: what of the file is not kept is told.
    """
    with _opened(path) as container:
        for array in _decoded(path, container, aloud):
            yield _pixels(array)


def _read_folder(path: Path, rate: float) -> Clip:
    names = frame_names(path)
    pictures = [read_array(name) for name in names]
    height, width, _ = pictures[0][0].shape
    for name, (array, _) in zip(names, pictures, strict=True):
        if array.shape[:2] != (height, width):
            here = f"{array.shape[1]}x{array.shape[0]}"
            raise InputError(f"{name} is {here} but {names[0].name} is {width}x{height}; all frames must have one size")
    kind = richest([kind for _, kind in pictures], names)
    frames = torch.empty(len(kind.channels), len(names), height, width, dtype=torch.float32)
    for t, (array, own) in enumerate(pictures):
        frames[:, t] = as_kind(to_pixels(array), own, kind)
    return Clip(frames, rate, kind)


def _is_frame(path: Path) -> bool:
    return path.suffix.lower() in _FRAME_SUFFIXES and not path.name.startswith(".")


def _in_order(path: Path) -> tuple[list[str | int], str]:
    """What sorts files by their names, numbers in them by value."""
    parts = re.split(r"(\d+)", path.name)  # text and digits by turns
    return [int(part) if number % 2 else part for number, part in enumerate(parts)], path.name


def _read_file(path: Path) -> Clip:
    with _opened(path) as container:
        stream = container.streams.video[0]
        rate = float(stream.average_rate or 25)
        arrays = []
        for array in _decoded(path, container):
            arrays.append(array)
            if len(arrays) * array.shape[0] * array.shape[1] > MOST_PIXELS:
                raise InputError(f"{path} has more than 2^28 pixels in all its frames; give a shorter or smaller video")
        clear = has_alpha(stream)
    frames = torch.empty(arrays[0].shape[2], len(arrays), *arrays[0].shape[:2], dtype=torch.float32)
    for t, array in enumerate(arrays):
        frames[:, t] = _pixels(array)
    return Clip(frames, rate, _WITH_ALPHA if clear else _COLORS)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """A video file's container; InputError for what is none, or if it breaks off."""
    import av

    with reading(path, "a video file"):
        path.stat()
    try:
        with av.open(str(path)) as container:
            if not container.streams.video or container.streams.video[0].codec_context is None:
                raise InputError(f"{path} holds no video that can be read; give an .mp4, a .gif or a folder of frames")
            yield container
    except (av.FFmpegError, OSError) as error:
        said = error.strerror or error
        raise InputError(f"{path} is no video that can be read ({said}); give an .mp4, a .gif or a folder") from error


def _decoded(path: Path, container: Any, aloud: bool = True) -> Iterator[np.ndarray]:
    """Frames (H, W, 3 or 4), one by one; after the last InputError for what is not whole or has frames unlike.

    aloud: what of the file is not kept is told. A transport stream that ends between two frames seems whole.
    """
    stream, shape, times, sound, count = container.streams.video[0], None, list[float](), False, 0
    clear = has_alpha(stream)
    for frame in frames_with_alpha(container, stream) if clear else container.decode(stream):
        if sound and frame.is_corrupt:  # those before the first sound one may lack what they are told by
            raise InputError(f"{path} is damaged or cut off, it has a frame that is not whole; give the whole file")
        sound = not frame.is_corrupt
        array = frame.to_ndarray(format="rgba" if clear else "rgb24")
        times += [] if frame.time is None else [frame.time]
        if shape not in (None, array.shape):
            raise InputError(f"{path} has frames of differing sizes; all frames must have one size")
        shape, count = array.shape, count + 1
        yield array
    _check_whole(path, container, times)
    if aloud:
        _tell(path, bool(container.streams.audio), times, float(stream.average_rate or 25))
    if shape is None:
        raise InputError(f"{path} has no frames; give a longer video")
    if count == 1 and path.suffix.lower() == ".gif":
        raise InputError(f"{path} is a still picture but GIF is read as video; convert it to PNG")


def _pixels(array: np.ndarray) -> Tensor:
    """A decoded frame (H, W, C) as (C, H, W) in [0, 1]."""
    return torch.from_numpy(array).permute(2, 0, 1) / 255


def _check_whole(path: Path, container: Any, times: list[float]) -> None:
    """Refuse a file that was cut off: it ends before the time that it tells, or, a GIF, without its last byte."""
    stream = container.streams.video[0]
    length = 0.0
    if stream.duration:
        length = float(stream.duration * stream.time_base)
    elif container.duration and not container.streams.audio:
        length = container.duration / 1e6
    shown = times[-1] - times[0] + float(np.diff(times).max()) if len(times) > 1 else length
    if shown < _WHOLE * length:
        raise InputError(
            f"{path} ends after {shown:.3g} of the {length:.3g} s that it says it has; give the whole file"
        )
    if path.suffix.lower() == ".gif" and not path.read_bytes().rstrip(b"\0").endswith(b";"):
        raise InputError(f"{path} is cut off, it lacks the end of a GIF; give the whole file")


def _tell(path: Path, loud: bool, times: list[float], rate: float) -> None:
    """Say what of a file is not kept: its sound, and how long each frame is shown."""
    if loud:
        note(f"{path} has sound, which is left out")
    gaps = np.diff(times)
    if len(gaps) and 0 < gaps.min() * _EVEN < gaps.max():
        each = f"{gaps.min():.3g} to {gaps.max():.3g} s each"
        note(f"{path} shows its frames for {each}; all are taken to last alike, {rate:.4g} a second")


def _bytes(frames: Iterable[Tensor], alpha: bool = False) -> Iterator[np.ndarray]:
    """Each frame (C, H, W) as (H, W, 3) uint8, or (H, W, 4) where its last channel is an alpha to be kept."""
    for frame in frames:
        color = frame[:3] if len(frame) >= 3 else frame[:1].expand(3, -1, -1)
        color = torch.cat([color, frame[-1:]]) if alpha else color
        yield np.ascontiguousarray((color.clamp(0, 1) * 255).round().byte().permute(1, 2, 0).numpy())


def _save_folder(target: Path, frames: Iterable[Tensor], kind: Kind) -> None:
    target.mkdir()
    for t, frame in enumerate(frames):
        name = target / f"{t:06d}{frame_ending(kind)}"
        write_files({name: image_writer(name, frame, kind)}, overwrite=False)
