"""A picture made to tile, changed as little as can be: only a band along its seams is sewn anew, out of itself.

Repeated as it is, a picture meets itself in a line. That line is covered by patches of the picture, one beside the
other, each laid where it fits what is around it and cut along the seam of least cost (Kwatra et al. 2003, section 3.1),
which keeps elements whole; patches then replace each other where that lowers the cost of all seams. In a texture that
runs along an axis, as wood does, seams cost less beside its lines (`kwatra.elements.easier`). Steps of color along
seams are spread over some pixels by the picture x whose gradients are nearest to those of the patches,

    sum_(s,t) (x_t - x_s - g_st)^2 + (x - c)^2 / REACH^2,    x = c outside of the band,

c the colors of the patches and g their differences, across a seam the mean of both patches' (Perez, Gangnet and Blake
2003, "Poisson Image Editing", screened). All other pixels are the picture's own.
"""

import math
from collections.abc import Callable, Iterator

import numpy as np
import torch
from torch import Tensor

from kwatra import Exemplar, InputError, Result, element_size
from kwatra.base import conjugate_gradients, generator_of, is_whole
from kwatra.elements import anisotropy, easier, runs_along
from kwatra.pieces import Box, Cut, Mosaic, Patch, Sheet
from kwatra.pieces.fitting import Fit
from kwatra.pieces.seams import eased
from kwatra.pieces.start import FIBROUS
from synth.texture.filling import planes_of
from synth.texture.form import Form, Image
from synth.texture.periods import whole_size
from synth.texture.synthesis import Synthesis

NARROWEST, WIDEST, PART = 12, 64, 8
"""Limits of the band's width on each side of a seam, in pixels, and as one of so many parts of the shorter side. Within
them it is as wide as a texture element, which gives seams room to run around one."""

CLEARED = 6
"""Of the band so many parts, next to the seam, are one that is always replaced."""

CANDIDATES = 12
"""Of so many places that fit best the one whose cut costs least is taken. With 4 stones were cut that 12 left whole;
tuned, as REACH, by eye on gravel, radishes, a stone wall and peeling plaster."""

APART = 2
"""Candidates are further than so many pixels from each other."""

SLIM, SLIMMEST = 0.25, 4
"""Where lines of the texture run into a border, patches are so many times as wide along it, at least so many pixels:
each has to continue fewer of them. In nine pictures of fibers made in code the steepest column of the tile is 5.6 times
what columns usually are, with .5 7.6 and with squares 9.0; with .125 3.7, but brushed metal is worse, 2.4 for 2.0."""

MENDING = 1
"""How often all patches are tried again; once more lowered the cost of all seams by no more than a hundredth."""

REACH = 8.0
"""Over about so many pixels steps of color are spread."""

SLIGHT = 1 / 256
"""What blending would change by less, as a part of the range of values, is not seen, and stays as it is."""

LEAST = 16
"""A picture to be tiled has at least so many pixels a side."""

Report = Callable[[str, float], None]


def tile(
    image: Image,
    *,
    axes: str = "xy",
    band: int | None = None,
    crop: bool = False,
    seed: int = 0,
    report: Report = lambda what, part: None,
) -> Synthesis[Image]:
    """This picture, made to repeat without a seam: a band at its borders is sewn anew, the rest stays bit for bit.

    image: a tensor (C, H, W), or an array (H, W) or (H, W, C), as for `synthesize`. axes: where it is to repeat: "x"
    from left to right, "y" from top to bottom, or "xy". band: up to so many pixels from these borders may change, at
    most a quarter of the shorter side; default: a texture element, 12 to 64, at most an eighth. crop: cut the picture
    first to whole periods of a texture that repeats. seed: another one, another seam. report: told what is being done
    and the part of it that is done.

    The result's `source` says where each pixel comes from, also those that stayed; so `take` makes any map of the
    picture tile with it. Raises InputError for what cannot be used, and with `crop` for a picture without a period.
    """
    if axes not in ("x", "y", "xy"):
        raise InputError(f"axes is {axes!r}; allowed are 'x', 'y' and 'xy'")
    form: Form[Image] = Form.of([image])
    pixels = form.normalized(image)
    if pixels.ndim != 3:
        raise InputError(f"the picture has shape {tuple(image.shape)}, as videos have; give an image")
    down, across = _whole_periods(pixels, axes) if crop else (slice(0, side) for side in pixels.shape[1:])
    pixels = pixels[:, down, across].contiguous()
    band = _band_of(pixels, axes, band)
    sewing = _Sewing(pixels, (("y" in axes), ("x" in axes)), band, seed)
    sewing.run(report)
    report("blending", 1.0)
    where = sewing.source() + np.array([0, down.start, across.start])[:, None, None]
    patches, smooth = sewing.patches(), sewing.blended()
    spread = ((smooth - patches).abs().amax(0) > SLIGHT).numpy()
    result = Result(torch.from_numpy(np.where(spread, smooth, patches)), torch.from_numpy(where),
                    torch.from_numpy(where[1:]), [], [], "the seams are closed")  # fmt: skip
    tiled = Synthesis(image, where, result, form).take(image)
    planes_of(tiled)[:, spread] = planes_of(form.restored(result.image))[:, spread]
    return Synthesis(tiled, where, result, form)


def _whole_periods(pixels: Tensor, axes: str) -> tuple[slice, ...]:
    """The box of the picture that holds whole periods, its borders where they differ least."""
    sizes = whole_size([pixels], pixels.shape[1:], axes, crop=True)
    if sizes is None:
        raise InputError("no period was found that the picture could be cropped to; leave the cropping out")
    box: list[slice] = []
    for axis, (size, side) in enumerate(zip(sizes, pixels.shape[1:], strict=True), 1):
        room = side - size + 1
        beyond = min(size, side - 1)  # the row that repeats the first one; of an uncropped side there is none
        differing = (pixels.narrow(axis, 0, max(room - 1, 1)) - pixels.narrow(axis, beyond, max(room - 1, 1))).abs()
        start = int(differing.transpose(1, axis).mean((0, 2)).argmin())
        box.append(slice(start, start + size))
    return tuple(box)


def _band_of(pixels: Tensor, axes: str, band: int | None) -> int:
    """The band's width, checked against the sides along which the picture repeats."""
    height, width = pixels.shape[1:]
    if min(height, width) < LEAST:
        raise InputError(f"the picture is {width}x{height}; at least {LEAST}x{LEAST} are needed to tile it")
    most = min(height, width) // 4
    if band is None:
        wanted = max(round(element_size(Exemplar.of([pixels]))), NARROWEST)
        return min(wanted, WIDEST, max(min(height, width) // PART, 4))
    if not (is_whole(band, 2) and band <= most):
        raise InputError(
            f"the band is {band} pixels; of {width}x{height} it is a whole number from 2 to {most}, a quarter of a side"
        )
    return int(band)


class _Sewing:
    """A picture on a sheet that is closed along some axes, and the patches that cover where it meets itself."""

    def __init__(self, pixels: Tensor, closed: tuple[bool, bool], band: int, seed: int) -> None:
        self.closed, self.band = closed, band
        self.shape = (pixels.shape[1], pixels.shape[2])
        self.mosaic = Mosaic([pixels.numpy()])
        exemplar = Exemplar.of([pixels])
        self.runs = runs_along(anisotropy(exemplar), FIBROUS)
        self.sheet = Sheet(self.mosaic, self.shape, closed, eased(self.mosaic, easier(exemplar, self.runs)))
        self.generator = generator_of(seed)
        self._fit = Fit(self.mosaic.matching(0))
        self._lay_picture()

    def _lay_picture(self) -> None:
        """The picture in its place, but for what is next to the seams; its inside stays."""
        cleared = max(self.band // CLEARED, 1)
        halves = [[(cleared * wraps, n // 2), (n // 2, n - cleared * wraps)] for n, wraps in self._axes]
        for top, bottom in halves[0]:
            for left, right in halves[1]:
                self.sheet.lay(Patch(0, (0, 0), Box((top, left), (bottom - top, right - left))))
        inside = tuple(slice(self.band * wraps, n - self.band * wraps) for n, wraps in self._axes)
        self.sheet.fixed[inside] = True

    @property
    def _axes(self) -> list[tuple[int, bool]]:
        return list(zip(self.shape, self.closed, strict=True))

    def run(self, report: Report) -> None:
        """Cover the seams, then try all patches again."""
        stations = list(self._stations())
        for turn in range(1 + MENDING):
            for number, box in enumerate(stations):
                cut = self._cheapest(box)
                empty = turn == 0 and not self.sheet.filled_at(self.sheet.indices(box)).all()
                if empty or cut.price < 0:
                    self.sheet.commit(cut)
                report("sewing", (turn + (number + 1) / len(stations)) / (1 + MENDING))

    def _stations(self) -> Iterator[Box]:
        """Boxes as deep as the band on both sides of a seam, half over each other: where seams cross, then along them.

        The first lies somewhere, as drawn. They are as wide as deep, or slim where lines of the texture run across.
        """
        deep = 2 * self.band
        if all(self.closed):
            yield self._box((-self.band,) * 2, (deep,) * 2)
        for across, along in ((0, 1), (1, 0)):
            if not self.closed[across]:
                continue
            wide = max(round(SLIM * deep), SLIMMEST) if self.runs == across else deep
            step, (length, wraps) = wide // 2, self._axes[along]
            count = math.ceil((length if wraps else length - wide) / step) + (not wraps)
            first = int(torch.randint(step, (1,), generator=self.generator)) if wraps else 0
            for number in range(count):
                start = first + number * length // count if wraps else (length - wide) * number // max(count - 1, 1)
                corner, extent = (-self.band, start), (deep, wide)
                yield self._box(corner, extent) if across == 0 else self._box(corner[::-1], extent[::-1])

    def _box(self, corner: tuple[int, int], extent: tuple[int, int]) -> Box:
        return Box(corner, extent).clipped(self.shape, self.closed)

    def _cheapest(self, box: Box) -> Cut:
        """Of the patches that fit a box best the one that can be cut in at the least price."""
        at = self.sheet.indices(box)
        known = self.sheet.filled_at(at).astype(np.float32)
        cost = self._fit.inside(self.mosaic.matching_at(self.sheet.places[at]) * known, known)
        cuts: list[Cut] = []
        while len(cuts) < CANDIDATES and np.isfinite(cost).any():
            place = np.unravel_index(int(cost.argmin()), cost.shape)
            shift = tuple(int(start - p) for start, p in zip(box.start, place, strict=True))
            cuts.append(self.sheet.cut(Patch(0, shift, box)))
            cost[tuple(slice(max(p - APART, 0), p + APART + 1) for p in place)] = np.inf
        return min(cuts, key=lambda cut: cut.price)

    def source(self) -> np.ndarray:
        """Where each pixel comes from, (3, H, W): image 0, row, column."""
        number, place = self.mosaic.coordinates(self.sheet.places)
        return np.concatenate([number[None], place]).astype(np.int64)

    def patches(self) -> Tensor:
        """The picture (C, H, W) as its patches have it."""
        return torch.from_numpy(self.mosaic.originals(self.sheet.places))

    def blended(self) -> Tensor:
        """The picture (C, H, W) that has, as nearly as can be, the patches' gradients and no steps between them."""
        colors = self.patches()
        steps = [self._missing(colors, axis) for axis in (0, 1)]
        free = torch.from_numpy(~self.sheet.fixed).to(colors)
        pairs = [self._pairs(axis) for axis in (0, 1)]

        def system(change: Tensor) -> Tensor:
            change = change * free
            pull = change / REACH**2
            for axis, pair in enumerate(pairs, 1):
                pull = pull - _divergence(pair * (change.roll(-1, axis) - change), axis)
            return pull * free

        pulls = [_divergence(pair * step, axis) for axis, (pair, step) in enumerate(zip(pairs, steps, strict=True), 1)]
        diagonal = torch.stack([pair + pair.roll(1, axis) for axis, pair in enumerate(pairs)]).sum(0) + 1 / REACH**2
        right = -(pulls[0] + pulls[1]) * free
        return colors + conjugate_gradients(system, right, diagonal, torch.zeros_like(colors), 1e-3).x * free

    def _pairs(self, axis: int) -> Tensor:
        """(H, W) 1 where a pixel and the next along an axis are neighbors."""
        pairs = torch.ones(self.shape, dtype=torch.float32)
        if not self.closed[axis]:
            pairs.select(axis, -1).zero_()
        return pairs

    def _missing(self, colors: Tensor, axis: int) -> Tensor:
        """Differences (C, H, W) to the next pixel along an axis: both patches' mean less that of the colors."""
        places = self.sheet.places
        after = np.roll(places, -1, axis)
        ahead = torch.from_numpy(self.mosaic.originals(self.mosaic.beyond(places, axis, 1)))
        back = torch.from_numpy(self.mosaic.originals(self.mosaic.beyond(after, axis, -1)))
        there = colors.roll(-1, axis + 1)
        return ((ahead - colors) + (there - back)) / 2 - (there - colors)


def _divergence(flow: Tensor, axis: int) -> Tensor:
    return flow - flow.roll(1, axis)
