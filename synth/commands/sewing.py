"""What `kwatra quilt` and `kwatra merge` share: settings, and the pictures and maps of seams."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth import io, quilting
from synth.commands.parsing import Parser, number
from synth.commands.telling import details

if TYPE_CHECKING:
    from synth.io import Array, Kind, Writer
    from synth.quilting import Quilt, QuiltSettings

_FIELDS = ("placement", "k", "refine", "seconds", "tile", "rotate", "mirror", "scale", "perspective")


def add_blending(parser: Parser, default: str) -> None:
    """Add how seams are blended."""
    blend = parser.add_mutually_exclusive_group()
    blend.add_argument("--feather", type=number(0, 100), metavar="S", help="blend seams by a Gaussian of S pixels "
                       f"({default})")  # fmt: skip
    blend.add_argument("--spline", action="store_true", help="blend seams by multi-resolution splining")


def settings_of(base: "QuiltSettings", arguments: argparse.Namespace, **more: Any) -> "QuiltSettings":
    """The settings that the command line names, the others from `base`."""
    import dataclasses

    given = {name: getattr(arguments, name, None) for name in (*_FIELDS, "feather", "spline", "seed")}
    given["tile"] = None if given["tile"] is None else True
    given["normalized"] = getattr(arguments, "edges", None)
    if given["spline"]:
        given["feather"] = 0.0
    return dataclasses.replace(base, **({name: v for name, v in given.items() if v is not None} | more))


def seams_kind() -> "Kind":
    """The kind of a picture in which seams are drawn."""
    return io.Kind("uint8", ("R", "G", "B"))


def extra_writers(arguments: argparse.Namespace, result: "Quilt", rate: float = 25.0) -> "dict[Path, Writer]":
    """What writes the seams and, of a video that plays at `rate`, the map."""
    writers: dict[Path, Writer] = {}
    if arguments.seams is not None:
        drawn = quilting.seams_drawn(result)
        if drawn.ndim == 4:
            writers[arguments.seams] = io.video_writer(arguments.seams, drawn.unbind(1), rate, seams_kind())
        else:
            writers[arguments.seams] = io.image_writer(arguments.seams, drawn, seams_kind())
    if result.image.ndim == 4 and arguments.map is not None:
        writers[arguments.map] = io.npy_writer(_variants(result).astype("int32"))
    return writers


def _variants(result: "Quilt") -> "Array":
    """Of which variant, and where there, each pixel is: (variant, t, y, x) by (4, T, H, W)."""
    import numpy as np

    return np.concatenate([result.source.numpy()[None], result.offset.numpy() + np.indices(result.patch.shape)])


def sewn(result: "Quilt", output: Path, kind: "Kind") -> str:
    """Details of a summary: how it is sewn."""
    cost = f"{result.history[0]:.1f} before and {result.cost:.1f} after refining, in color ranges times pixels"
    rows = {"file": output.resolve(), "pixels": kind, "seams cost": cost, "ended because": result.stopped}
    return details(rows)
