"""Image and video synthesis by graph-cut quilting: settings, the one function, and what it returns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from kwatra.base import InputError, floats_of, generator_of, whole_sizes
from kwatra.pieces.seams import LEVELS, NORMALIZED_SCALE, Mosaic, SeamCost, normalized
from kwatra.pieces.sheet import Budget, Sheet
from synth.quilting.blendseams import FRAMES_PER_PIXEL, blending_reach, ending_reach, feather, spline
from synth.quilting.growth import Report, fill, refine
from synth.quilting.loops import unrolled
from synth.quilting.placement import Placer, Rule
from synth.quilting.variants import Variant, bands, variants

PLACEMENTS = ("random", "whole", "sub")


@dataclass(frozen=True)
class QuiltSettings:
    """How to quilt; every field has a default that suits most textures.

    `placement`: "whole" for regular and structured textures, "sub" for stochastic ones and for motion, "random" for the
    fastest. `k`: randomness of the choice among offsets, 0.001 to 1 (equation 3). `region`: the error-region's extent
    as a part of the exemplar's. `grid`: offsets are multiples of so many pixels across the picture; 4 by default, the
    offsets of a pyramid's coarsest grid: a sixteenth of them are enough to choose from, and what is copied stays the
    same at half and quarter size, where resampling would otherwise change it a little at every seam. `evenness`: how
    much a source region costs for being used already. `refine`: at most so many refinement patches; `patience`: stop
    after so many in a row that lowered nothing; `seconds`: or after this time (then the result depends on the machine).
    `normalized`: cost M' (equation 5) for M (equation 1). `tile`: the picture repeats without a seam.
    `rotate`: also variants turned by these angles, in degrees counterclockwise. `mirror`: also mirrored ones, but not
    where they would fold the picture about a line.
    `scale`: also variants of these sizes, 1 as large as the exemplar; `perspective`: only these, from the first at the
    top to the last at the bottom (figure 11).
    `feather`: blend seams by a Gaussian of so many pixels, and twice as many frames. `spline`: blend them by
    multi-resolution splining.
    """

    placement: str = "whole"
    k: float = 0.01
    region: float = 0.25
    grid: int = 4
    evenness: float = 0.02
    refine: int = 60
    patience: int = 15
    seconds: float | None = None
    normalized: bool = False
    tile: bool = False
    rotate: tuple[float, ...] = ()
    mirror: bool = False
    scale: tuple[float, ...] = ()
    perspective: bool = False
    feather: float = 0.0
    spline: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        if self.placement not in PLACEMENTS:
            raise InputError(f"placement is {self.placement!r} but must be one of {', '.join(PLACEMENTS)}")
        limits = (("k", 0.001, 1.0), ("region", 0.05, 0.5), ("grid", 1, 64), ("evenness", 0, 100), ("refine", 0, 10**6))
        for name, low, high in (*limits, ("patience", 1, 10**6), ("feather", 0, 100)):
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(f"{name} is {value:g} but must lie between {low:g} and {high:g}")
        if self.feather and self.spline:
            raise InputError("feather and spline are both asked for; choose one")
        if not all(0 < scale < math.inf for scale in self.scale):
            raise InputError(f"scale is {self.scale} but must be finite and positive numbers, for example (0.5, 1)")
        if self.perspective and (len(self.scale) < 2 or self.tile):
            raise InputError("perspective needs several scales, far to near, and no tiling")

    def cost_of(self, sources: Mosaic) -> SeamCost:
        """What seams between places of a mosaic cost."""
        return normalized(sources) if self.normalized else SeamCost(sources)


@dataclass(frozen=True)
class Quilt:
    """A synthesis and how it is sewn; S is the output's shape, (H, W) or (T, H, W), and d its length.

    `image` (C, *S) float32. `source` (*S,): which variant of the exemplar each pixel is from. `offset` (d, *S) int32:
    its place there minus its place in the output, in the order of the axes. `patch` (*S,): the patch it came with.
    `seams` (d, *S) float32: the cost of the seam between a pixel and the next along each axis, 0 where there is none,
    in units of colour range (equation 1, 1 is black against white). `cost`: their sum. `history`: that sum before
    refining and after each refinement step. `stopped`: why refining ended.
    """

    image: Tensor
    source: Tensor
    offset: Tensor
    patch: Tensor
    seams: Tensor
    cost: float
    history: tuple[float, ...]
    stopped: str


def quilt(
    exemplar: Tensor | Sequence[Tensor],
    size: Sequence[int],
    settings: QuiltSettings | None = None,
    report: Report = lambda what, part: None,
) -> Quilt:
    """A new texture of `size` (H, W) or (T, H, W) from an exemplar (C, H, W) or (C, T, H, W), values in any range.

    It is made on the CPU. Several exemplars of one texture may be given. Raises InputError for an exemplar that is too
    small or not finite, for some that differ in channels, or a size that does not fit.
    """
    settings = settings or QuiltSettings()
    exemplars = [floats_of(each).cpu() for each in ([exemplar] if isinstance(exemplar, Tensor) else exemplar)]
    for each in exemplars:
        check_exemplar(each)
        if (each.shape[0], each.ndim) != (exemplars[0].shape[0], exemplars[0].ndim):
            raise InputError(f"exemplars have shapes {tuple(exemplars[0].shape)} and {tuple(each.shape)}; give them "
                             "the same channels and axes")  # fmt: skip
    size = whole_sizes(size, exemplars[0].ndim - 1, "the size")
    sheet = new_sheet(sources_of(exemplars, settings), size, settings)
    smallest = [min(sides) for sides in zip(*(each.shape[1:] for each in exemplars), strict=True)]
    placer = new_placer(sheet, settings, error_region(smallest, settings.region))
    history, stopped = run(sheet, placer, settings, report)
    return result_of(sheet, settings, history, stopped)


def check_exemplar(exemplar: Tensor) -> None:
    """Raise InputError unless the exemplar is finite, (C, H, W) or (C, T, H, W), and large enough to overlap itself."""
    if exemplar.ndim not in (3, 4):
        raise InputError(f"the exemplar has shape {tuple(exemplar.shape)} but must be (C, H, W) or (C, T, H, W)")
    if min(exemplar.shape[-2:]) < 8:
        high, wide = exemplar.shape[-2:]
        raise InputError(
            f"the exemplar is {wide}x{high} pixels, smaller than the overlap of two patches; give at least 8x8"
        )
    if exemplar.ndim == 4 and exemplar.shape[1] < 2:
        raise InputError(
            "the video has one frame but needs at least two; give a longer one, or quilt the frame as an image"
        )
    if not bool(torch.isfinite(exemplar.max() - exemplar.min())):
        raise InputError("the exemplar has NaN or infinite values, or too large ones; replace them by finite ones")


def variants_of(exemplars: Sequence[Tensor], settings: QuiltSettings) -> list[tuple[int, Variant, tuple[float, float]]]:
    """All that is copied from: number of the exemplar, variant of it, and the part of the output it is for."""
    scales = [*settings.scale] if settings.perspective else [1.0, *(s for s in settings.scale if s != 1)]
    plain = [floats_of(exemplar).cpu() for exemplar in exemplars]
    return [
        (number, variant, part)
        for number, exemplar in enumerate(plain)
        for scale, part in zip(scales, bands(len(scales)), strict=True)
        for variant in variants(exemplar, scale, settings.rotate, settings.mirror)
    ]


def sources_of(exemplar: Tensor | Sequence[Tensor], settings: QuiltSettings) -> Mosaic:
    """The exemplar, or several, and the variants that the settings ask for."""
    made = variants_of([exemplar] if isinstance(exemplar, Tensor) else exemplar, settings)
    for _, variant, _ in made:
        check_exemplar(variant.image)
    return Mosaic(
        [variant.image.numpy() for _, variant, _ in made],
        [part for _, _, part in made] if settings.perspective else None,
        [variant.matrix for _, variant, _ in made],
        [number for number, _, _ in made],
    )


def new_sheet(sources: Mosaic, size: Sequence[int], settings: QuiltSettings) -> Sheet[Mosaic]:
    """An empty sheet; tiling closes the two axes of the picture, never time."""
    if settings.tile and min(size[-2:]) < 8:
        raise InputError(f"a tile of {size[-1]}x{size[-2]} pixels cannot meet itself; ask for at least 8x8")
    periodic = [settings.tile and axis >= len(size) - 2 for axis in range(len(size))]
    return Sheet(sources, size, periodic, settings.cost_of(sources))


def error_region(shape: Sequence[int], part: float) -> tuple[int, ...]:
    """The error-region's extent for an exemplar of `shape`."""
    return tuple(max(math.floor(n * part), min(n, 4), 1) for n in shape)


def new_placer(sheet: Sheet[Mosaic], settings: QuiltSettings, region: tuple[int, ...], **limits: Any) -> Placer:
    """A placer for a sheet; `limits` as of Rule.

    Along axes that it does not span, the error-region has at most half the extent of the smallest source.
    """
    smallest = [min(shape[d] for shape in sheet.sources.shapes) for d in range(len(region))]
    spans = zip(region, smallest, sheet.shape, strict=True)
    fitting = tuple(min(r, s if r >= min(s, n) else max(s // 2, 1)) for r, s, n in spans)
    if sheet.sources.bands is not None:
        lowest = int(min(high - low for low, high in sheet.sources.bands) * sheet.shape[-2]) // 2
        fitting = (*fitting[:-2], max(min(fitting[-2], lowest), 1), fitting[-1])
    limits.setdefault("margin", ending_reach(len(region), settings.feather, settings.spline))
    rule = Rule(settings.placement, settings.k, fitting, settings.evenness, **limits)
    return Placer(sheet, rule, generator_of(settings.seed))


def run(sheet: Sheet[Mosaic], placer: Placer, settings: QuiltSettings, report: Report) -> tuple[list[int], str]:
    """Fill and refine; the total seam cost before and after each refinement step, and why it stopped."""
    dims = len(sheet.shape)
    grid = tuple(settings.grid if axis >= dims - 2 else 1 for axis in range(dims))
    fill(sheet, placer, grid, report)
    return refine(sheet, placer, Budget(settings.refine, settings.patience, settings.seconds), grid, report)


def result_of(
    sheet: Sheet[Mosaic], settings: QuiltSettings, history: Sequence[int], stopped: str, first: int = 0
) -> Quilt:
    """The sheet as a Quilt; with `first`, its frames from there on, a loop: the last one is also the one before."""
    image = _image(sheet, settings, first)
    number, offset = sheet.sources.coordinates(sheet.places[first:])
    for axis, n in enumerate(offset.shape[1:]):
        offset[axis] -= np.arange(n, dtype=np.int32).reshape([-1 if d == axis else 1 for d in range(len(sheet.shape))])
    seams = sheet.seams[:, first:].copy()
    if first:
        seams[0, -1] = sheet.seams[0, first - 1]
    return Quilt(
        torch.from_numpy(image),
        torch.from_numpy(number),
        torch.from_numpy(offset),
        torch.from_numpy(sheet.label[first:].copy()),
        torch.from_numpy(seams.astype(np.float32) * np.float32(unit_of(sheet))),
        int(seams.sum(dtype=np.int64)) * unit_of(sheet),
        tuple(total * unit_of(sheet) for total in history),
        stopped,
    )


def unit_of(sheet: Sheet[Mosaic]) -> float:
    """What a seam cost of 1 is, in units of colour range (M), or of that over its slope (M')."""
    return 1.0 / NORMALIZED_SCALE if sheet.cost.steepness is not None else 1.0 / LEVELS


def _image(sheet: Sheet[Mosaic], settings: QuiltSettings, first: int) -> np.ndarray:
    if not (settings.feather or settings.spline):
        return sheet.sources.originals(sheet.places[first:])
    margin = blending_reach(FRAMES_PER_PIXEL * (settings.feather or 1.0)) if first else 0
    if margin:
        sheet = unrolled(sheet, first, margin)
    image = feather(sheet, settings.feather) if settings.feather else spline(sheet)
    return np.ascontiguousarray(image[:, margin : image.shape[1] - margin])
