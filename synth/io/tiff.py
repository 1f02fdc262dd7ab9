"""TIFF as arrays, and back, by tifffile."""

import io
import logging
from pathlib import Path
from typing import Any

import numpy as np

from kwatra.base import InputError
from synth.io.kinds import GRAY, ORIENTATION, RGB, Array, Kind, check_extent, upright

_PHOTOMETRICS = ("MINISWHITE", "MINISBLACK", "RGB", "PALETTE", "MASK", "YCBCR", "CFA")
"""What samples may mean; inks and Lab are no channels that textures can be mixed in."""
_INKS = {"SEPARATED": "CMYK", "CIELAB": "Lab", "ICCLAB": "Lab", "ITULAB": "Lab"}


def read_tiff(path: Path) -> tuple[Array, Kind]:
    """Pixels (H, W, C) and their kind."""
    import tifffile

    logging.getLogger("tifffile").setLevel(logging.CRITICAL)  # it tells of damage there and raises as well
    with tifffile.TiffFile(path) as file:
        page, series = file.pages.first, file.series[0]
        axes = series.axes.replace("I", "Q")
        if axes.strip("S") != "YX" and max(series.shape[i] for i, a in enumerate(axes) if a not in "YXS") > 1:
            raise InputError(
                f"{path} holds several pages; save one as a file of its own (channels as samples of one page)"
            )
        check_extent(path, page.imagewidth, page.imagelength, page.samplesperpixel)
        if (name := _photometric(page)) not in _PHOTOMETRICS:
            raise InputError(f"{path} holds {_INKS.get(name, name)} colors; convert it to RGB or gray")
        pixels = page.asarray()
        if page.planarconfig == 2 and page.samplesperpixel > 1:
            pixels = np.moveaxis(pixels.reshape(-1, *pixels.shape[-2:]), 0, -1)
        pixels = pixels.reshape(page.imagelength, page.imagewidth, -1)
        pixels = pixels.astype(pixels.dtype.newbyteorder("="), copy=False)
        pixels, names = _tiff_colors(page, pixels)
        profile, tag = page.tags.get("InterColorProfile"), page.tags.get(ORIENTATION)
        kind = Kind(
            pixels.dtype.name,
            names,
            premultiplied=1 in page.extrasamples,
            profile=bytes(profile.value) if profile is not None else b"",
        )
        return upright(pixels, int(tag.value) if tag is not None else 1), kind


def _photometric(page: Any) -> str:
    return str(getattr(page.photometric, "name", page.photometric))


def _tiff_colors(page: Any, pixels: Array) -> tuple[Array, tuple[str, ...]]:
    """Pixels whose larger values are lighter, without a palette; names of the channels."""
    photometric = _photometric(page)
    if photometric == "PALETTE":
        pixels = (page.colormap.T[pixels[..., 0]] >> 8).astype(np.uint8)
        return pixels, RGB
    if photometric == "MINISWHITE" and pixels.dtype.kind in "bu":
        pixels = ~pixels if pixels.dtype == bool else np.iinfo(pixels.dtype).max - pixels
    colors = RGB if photometric in ("RGB", "YCBCR") and pixels.shape[2] >= 3 else GRAY
    extras = [int(extra) for extra in page.extrasamples]
    extras += [0] * (pixels.shape[2] - len(colors) - len(extras))
    alpha = next((i for i, extra in enumerate(extras) if extra in (1, 2)), None)
    return pixels, (*colors, *("A" if i == alpha else f"X{i + 1}" for i in range(len(extras))))


def tiff_bytes(pixels: Array, kind: Kind) -> bytes:
    """A TIFF file's bytes."""
    import tifffile

    colors = 3 if kind.channels[:3] == RGB else 1
    alpha = "assocalpha" if kind.premultiplied else "unassalpha"
    stream = io.BytesIO()
    tifffile.imwrite(
        stream,
        pixels if pixels.shape[2] > 1 else pixels[..., 0],
        photometric="rgb" if colors == 3 else "minisblack",
        planarconfig="contig" if pixels.shape[2] > 1 else None,
        extrasamples=[alpha if name == "A" else "unspecified" for name in kind.channels[colors:]],
        compression=None if kind.dtype == "bool" else "zlib",
        predictor=kind.dtype in ("uint8", "uint16"),
        iccprofile=kind.profile or None,
        metadata=None,
        bigtiff=pixels.nbytes > 2**31,
    )
    return stream.getvalue()
