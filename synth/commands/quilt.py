"""`kwatra quilt` and `kwatra merge`: check everything, work, then write everything. Each returns what to print."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from kwatra.base import InputError
from synth.commands.progress import work_line
from synth.io.image_formats import Kind
from synth.io.images import Picture, Writer, check_output, image_writer, read_image, read_mask, write_files
from synth.io.videos import check_video_output, is_video, read_video, video_writer
from synth.quilting.draw import seams_drawn
from synth.quilting.merging import Overlay, merge
from synth.quilting.synthesis import Quilt, QuiltSettings, quilt
from synth.quilting.video import default_settings, quilt_video

_MOST_PIXELS = 2**28
_SEAMS_KIND = Kind("uint8", ("R", "G", "B"))


def run_quilt(arguments: argparse.Namespace) -> str:
    """`kwatra quilt`: returns the summary."""
    if arguments.threads:
        torch.set_num_threads(arguments.threads)
    return (_quilt_video if is_video(arguments.exemplar) else _quilt_image)(arguments)


def run_merge(arguments: argparse.Namespace) -> str:
    """`kwatra merge`: returns the summary."""
    overlays, at, keep, spare = arguments.overlays, arguments.at or [], arguments.keep, arguments.spare or []
    at = at or [(0, 0)] * len(overlays)
    for name, given in (("--at", at), ("--keep", keep), ("--spare", spare or overlays)):
        if len(given) != len(overlays):
            raise InputError(f"{name} is given {len(given)} times for {len(overlays)} overlays; give it once for each")
    pictures = [read_image(path) for path in (arguments.background, *overlays)]
    images, kind = _alike(pictures)
    masks = [[read_mask(path) for path in paths] for paths in (keep, spare)]
    output = arguments.output or Path(f"{arguments.background.stem}_merge{arguments.background.suffix}")
    check_output(output, kind, arguments.overwrite)
    _check_extras(arguments)
    spares: list[Tensor | None] = list(masks[1]) or [None] * len(overlays)
    layers = [Overlay(*parts) for parts in zip(images[1:], at, masks[0], spares, strict=True)]
    settings = _settings(QuiltSettings(), arguments, normalized=not arguments.plain)
    result = merge(images[0], layers, settings)
    writers = {output: image_writer(output, result.image, kind)} | _extra_writers(arguments, result)
    write_files(writers)
    return f"wrote {_names(writers)}: seams cost {result.cost:.1f}"


def _quilt_image(arguments: argparse.Namespace) -> str:
    picture = read_image(arguments.exemplar)
    for name in ("mode", "frames", "loop"):
        if getattr(arguments, name):
            raise InputError(f"--{name} is for videos but {arguments.exemplar} is an image; leave it out")
    height, width = arguments.size or [2 * n for n in picture.pixels.shape[1:]]
    _check_pixels(1, height, width)
    output = arguments.output or Path(f"{arguments.exemplar.stem}_quilt{arguments.exemplar.suffix}")
    check_output(output, picture.kind, arguments.overwrite)
    _check_extras(arguments)
    settings = _settings(QuiltSettings(), arguments)
    began = time.perf_counter()
    with work_line(f"{arguments.exemplar.name} to {width}x{height}") as report:
        result = quilt(picture.pixels, (height, width), settings, report)
    took = time.perf_counter() - began
    writers = {output: image_writer(output, result.image, picture.kind)} | _extra_writers(arguments, result)
    write_files(writers)
    return f"wrote {_names(writers)}: {width}x{height} in {took:.1f} s, {_sewn(result)}"


def _quilt_video(arguments: argparse.Namespace) -> str:
    source = arguments.exemplar
    output = arguments.output or Path(f"{source.stem}_quilt{'' if source.is_dir() else source.suffix}")
    check_video_output(output, arguments.overwrite)
    _check_extras(arguments, video=True)
    clip = read_video(source, arguments.fps or 25.0)
    size = arguments.size or tuple(clip.frames.shape[-2:])
    mode = arguments.mode or ("transition" if size == tuple(clip.frames.shape[-2:]) else "spacetime")
    _check_pixels(arguments.frames or 2 * clip.frames.shape[1], *size)
    began = time.perf_counter()
    with work_line(f"{source.name}, {mode}") as report:
        result = quilt_video(
            clip.frames,
            arguments.frames,
            size,
            mode=mode,
            loop=arguments.loop,
            hold=arguments.hold,
            settings=_settings(default_settings(mode), arguments),
            report=report,
        )
    took = time.perf_counter() - began
    rate = arguments.fps or clip.rate
    writers = {output: video_writer(output, result.image.unbind(1), rate, clip.kind)}
    if arguments.seams is not None:
        writers[arguments.seams] = video_writer(arguments.seams, seams_drawn(result).unbind(1), rate, _SEAMS_KIND)
    if arguments.map is not None:
        writers[arguments.map] = _map_writer(result)
    write_files(writers)
    frames, height, width = result.patch.shape
    return f"wrote {_names(writers)}: {frames} frames of {width}x{height} in {took:.1f} s, {_sewn(result)}"


def _settings(base: QuiltSettings, arguments: argparse.Namespace, **more: Any) -> QuiltSettings:
    """The settings that the command line names, the others from `base`."""
    import dataclasses

    names = ("placement", "k", "refine", "seconds", "tile", "rotate", "mirror", "scale", "perspective")
    given = {name: getattr(arguments, name, None) for name in (*names, "feather", "spline", "seed")}
    given["normalized"] = getattr(arguments, "edges", None)
    if given["spline"]:
        given["feather"] = 0.0
    return dataclasses.replace(base, **({name: v for name, v in given.items() if v is not None} | more))


def _check_pixels(frames: int, height: int, width: int) -> None:
    if frames * height * width > _MOST_PIXELS:
        raise InputError(
            f"{width}x{height} and {frames} frames are more than {_MOST_PIXELS} pixels in all; ask for a smaller --size"
        )


def _check_extras(arguments: argparse.Namespace, video: bool = False) -> None:
    if arguments.seams is not None and video:
        check_video_output(arguments.seams, arguments.overwrite)
    elif arguments.seams is not None:
        check_output(arguments.seams, _SEAMS_KIND, arguments.overwrite)
    if getattr(arguments, "map", None) is not None:
        check_output(arguments.map, None, arguments.overwrite, (".npy",))
    outputs = [p for p in (arguments.output, arguments.seams, getattr(arguments, "map", None)) if p is not None]
    if len({p.resolve() for p in outputs}) < len(outputs):
        raise InputError("two of the files to write have one name; give each its own")


def _extra_writers(arguments: argparse.Namespace, result: Quilt) -> dict[Path, Writer]:
    writers: dict[Path, Writer] = {}
    if arguments.seams is not None:
        writers[arguments.seams] = image_writer(arguments.seams, seams_drawn(result), _SEAMS_KIND)
    if getattr(arguments, "map", None) is not None:
        writers[arguments.map] = _map_writer(result)
    return writers


def _map_writer(result: Quilt) -> Writer:
    place = result.offset.numpy() + np.indices(result.patch.shape, dtype=np.int32)
    table = np.concatenate([result.source.numpy()[None], place]).astype(np.int32)

    def write(target: Path) -> None:
        with target.open("wb") as file:
            np.save(file, table)

    return write


def _alike(pictures: Sequence[Picture]) -> tuple[list[Tensor], Kind]:
    """Images of one kind: gray ones become colour where any is; alpha stays only if all have it."""
    kinds = {picture.kind.channels for picture in pictures}
    if len(kinds) == 1:
        return [picture.pixels for picture in pictures], pictures[0].kind
    best = next((p.kind for p in pictures if p.kind.channels == ("R", "G", "B")), _SEAMS_KIND)
    return [_color(picture) for picture in pictures], best


def _color(picture: Picture) -> Tensor:
    names = picture.kind.channels
    if names[:3] == ("R", "G", "B"):
        return picture.pixels[:3]
    if names[0] == "Y":
        return picture.pixels[:1].expand(3, -1, -1)
    raise InputError(
        f"an image has the channels {', '.join(names)}, which cannot be merged with others; convert it to RGB"
    )


def _sewn(result: Quilt) -> str:
    return f"seams cost {result.history[0]:.1f} before and {result.cost:.1f} after refining ({result.stopped})"


def _names(paths: Any) -> str:
    return ", ".join(str(path) for path in paths)
