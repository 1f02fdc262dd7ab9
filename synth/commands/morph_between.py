"""`kwatra morph A B C`, and with a map: textures between several, the same everywhere or each pixel its own."""

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io
from synth.commands.checks import check_distinct, check_size, finish, refuse_unused, set_up
from synth.commands.morph_folder import Folder
from synth.commands.morph_options import in_order, method_options
from synth.words import counted

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from torch import Tensor

    from synth.io import Kind, Writer

_FILM = ("frames", "energy", "flow", "show_masks")
MASK = ("uint8", ("Y",))
"""How maps of what lies where are written."""


def is_between(arguments: argparse.Namespace) -> bool:
    """Whether what is asked lies between several textures, or differs from place to place."""
    several = arguments.more or arguments.map or arguments.weights
    return bool(several) or isinstance(arguments.at, tuple)


def run_between(arguments: argparse.Namespace) -> str:
    """Check everything, work, write everything; returns the summary."""
    from synth.commands.progress import work_line

    set_up(arguments)
    if arguments.method not in (None, "patches"):
        raise synth.InputError(
            f"--method is {arguments.method}, but maps, weights and further textures are for patches; leave it out"
        )
    refuse_unused(arguments, _FILM, "is for films from A to B")
    refuse_unused(arguments, ("retexture",), "is for films whose frames are no textures, these are")
    paths = [arguments.a, arguments.b, *arguments.more]
    pictures, kind = io.raised([io.read_image(path) for path in paths], paths)
    weights = _weights(arguments, len(paths))
    film = len(weights) > 1 and not isinstance(weights, tuple)
    output = arguments.output or Path("_".join(path.stem for path in paths) + ".png")
    _check(arguments, output, kind, film)
    masks = None if arguments.features is None else [io.read_mask(path) for path in arguments.features]
    options = method_options(arguments, "patches", pictures)
    began = time.perf_counter()
    with work_line(" ".join(path.name for path in paths)) as report:
        made = synth.interpolate(
            [io.premultiplied(picture, kind) for picture in pictures],
            weights,
            size=arguments.size,
            features=masks,
            tile=arguments.tile,
            preset=arguments.preset,
            seed=arguments.seed,
            callback=report,
            **options,
        )
        back = arguments.there_and_back
        order = in_order(len(made.frames), back)
        height, width = made.frames[0].shape[1:]
        folder = Folder(output, len(order))
        once = (made.frames[number] for number in order) if back else made.frames.once()
        frames = (io.straight(frame, kind) for frame in once)
        extremes = io.extremes_of(kind, pictures)
        writers = {output: _writer(folder, frames, arguments.fps, kind, extremes)}
        finish(writers | features_writers(arguments.show_features, made.features), arguments.overwrite)
        folder.tell()
    took = time.perf_counter() - began
    count = f"{counted(len(order), 'frame')} of " if film else ""
    told = "".join(f"\n{remark}" for remark in made.remarks)
    return f"wrote {output}: {count}{width}x{height} in {took:.1f} s{told}"


def features_writers(paths: "Sequence[Path] | None", features: "Sequence[Tensor]") -> "dict[Path, Writer]":
    """What writes the maps of features as images, white on black."""
    if paths is None:
        return {}
    return {
        path: io.image_writer(path, each[None].float(), synth.Kind(*MASK))
        for path, each in zip(paths, features, strict=True)
    }


def check_features(paths: "Sequence[Path] | None", count: int, overwrite: bool) -> None:
    """Refuse another number of files than textures, and files that may not be written."""
    if paths is not None and len(paths) != count:
        raise synth.InputError(
            f"--show-features names {counted(len(paths), 'file')} for {count} textures; name {count}"
        )
    for path in paths or ():
        io.check_output(path, synth.Kind(*MASK), overwrite)


def _weights(arguments: argparse.Namespace, count: int) -> "tuple[float, ...] | Sequence[Tensor]":
    """Weights of the textures, or the map of each frame; InputError unless they are given once."""
    given = [name for name in ("map", "weights", "at") if getattr(arguments, name) is not None]
    if len(given) != 1:
        asked = "nothing" if not given else "both --" + " and --".join(given)
        raise synth.InputError(f"{asked} says what lies where; give one of --at W,W,..., --weights and --map")
    if given == ["at"]:
        return _at(arguments.at, count)
    if given == ["map"] and count != 2:
        raise synth.InputError(
            f"--map leads from A to B but there are {count} textures; give --weights, or two textures"
        )
    path = getattr(arguments, given[0])

    def shown(image: "Tensor") -> "Tensor":
        if given == ["map"]:
            return image[:3].mean(0)
        if not count <= len(image) <= count + 1:
            raise synth.InputError(
                f"{path} has {counted(len(image), 'channel')} but there are {count} textures; give an image with one "
                "channel for each (red, green, blue for three)"
            )
        return image[:count]

    return io.Reel(path, shown) if io.is_video(path) else [shown(io.read_image(path).pixels)]


def _at(at: float | tuple[float, ...], count: int) -> tuple[float, ...]:
    """The weights of `count` textures that --at says, as they are or as a time."""
    if isinstance(at, tuple):
        return at
    if count != 2:
        even = ",".join(["1"] * count)
        raise synth.InputError(
            f"--at {at:g} is a time from A to B but there are {count} textures; give the weight of each (--at {even})"
        )
    return 1 - at, at


def _check(arguments: argparse.Namespace, output: Path, kind: "Kind", film: bool) -> None:
    if arguments.size is not None:
        check_size(arguments.size)
    if not film:
        refuse_unused(arguments, ("there_and_back",), "is for films, and this is one image")
        if not output.suffix:
            raise synth.InputError(f"{output} cannot hold one image; end it with .png, .tif or another kind of image")
    if is_image(output):
        io.check_output(output, kind, arguments.overwrite)
    else:
        io.check_video_output(output, arguments.overwrite)
    count = 2 + len(arguments.more)
    if arguments.features is not None and len(arguments.features) != count:
        raise synth.InputError(
            f"--features names {counted(len(arguments.features), 'file')} for {count} textures; name {count}"
        )
    check_features(arguments.show_features, count, arguments.overwrite)
    check_distinct([output, *(arguments.show_features or ())])


def _writer(
    folder: Folder, frames: "Iterator[Tensor]", rate: float, kind: "Kind", extremes: tuple[float, float]
) -> "Writer":
    from synth.sheets import contact_sheet

    output = folder.path
    if is_image(output):
        shown = list(frames)
        return io.image_writer(output, shown[0] if len(shown) == 1 else contact_sheet(shown), kind)
    writer = io.video_writer(output, frames, rate, kind, extremes)
    return writer if output.suffix else folder.keeping(writer)


def is_image(output: Path) -> bool:
    """Whether all is written into one picture, not a video or a folder."""
    return bool(output.suffix) and not is_video(output)


def is_video(output: Path) -> bool:
    """Whether it is written into a video file."""
    return output.suffix.lower() in io.VIDEO_SUFFIXES
