"""A picture made to tile, changed as little as can be: only a band along its seams is sewn anew, out of itself.

Repeated as it is, a picture meets itself in a line. That line is covered by patches of the picture, one beside the
other (`synth.texture.sewing`). All other pixels are the picture's own, unless light falls unevenly on it, which would
be seen as a step where it meets itself, or as a pattern: that is taken out of all of it before.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import torch
from torch import Tensor

from kwatra import Exemplar, InputError, Result, element_size
from kwatra.base import generator_of, is_whole
from kwatra.elements import drawn_sides
from kwatra.levels import LAID_FINE
from kwatra.pieces import Box
from synth.texture.filling import planes_of
from synth.texture.form import Form, Image
from synth.texture.illumination import Light, find_light
from synth.texture.periods import whole_size
from synth.texture.sewing import Sewing
from synth.texture.synthesis import Synthesis

NARROWEST, WIDEST, PART = 12, 64, 8
"""Limits of the band's width on each side of a seam, in pixels, and as one of so many parts of the shorter side. Within
them it is as wide as a texture element, which gives seams room to run around one. WIDEST is in the pixels of what is
sewn, the picture halved until it has `LAID_FINE` of them: a bound on time."""

CLEARED = 6
"""Of the band so many parts, next to the seam, are one that is always replaced."""

SLIM, SLIMMEST = 0.25, 4
"""Where lines of the texture run into a border, patches are so many times as wide along it, at least so many pixels:
each has to continue fewer of them. In nine pictures of fibers made in code the steepest column of the tile is 5.6 times
what columns usually are, with .5 7.6 and with squares 9.0; with .125 3.7, but brushed metal is worse, 2.4 for 2.0."""

MENDING = 1
"""How often all patches are tried again; once more lowered the cost of all seams by no more than a hundredth."""

NEAR = 1024
"""Patches are sought on so many pixels about where they are laid: a bound on time and memory, not tuned."""

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

    Where light falls unevenly on it, it is taken out: all of the picture is then as under even light.

    image: a tensor (C, H, W), or an array (H, W) or (H, W, C), as for `synthesize`. axes: where it is to repeat: "x"
    from left to right, "y" from top to bottom, or "xy". band: up to so many pixels from these borders may change, at
    most a quarter of the shorter side; default: a texture element, 12 to 64 or, of over half a megapixel, more, at most
    an eighth. crop: cut the picture first to whole periods of a texture that repeats. seed: another one, another seam.
    report: told what is being done and the part of it that is done.

    The result's `source` says where each pixel comes from, also those that stayed; so `take` makes any map of the
    picture tile with it. `even` is the picture under even light, and empty if it was. Raises InputError for what cannot
    be used, and with `crop` for a picture without a period.
    """
    if axes not in ("x", "y", "xy"):
        raise InputError(f"axes is {axes!r}; allowed are 'x', 'y' and 'xy'")
    form: Form[Image] = Form.of([image])
    pixels = form.normalized(image)
    if pixels.ndim != 3:
        raise InputError(f"the picture has shape {tuple(image.shape)}, as videos have; give an image")
    light = find_light(pixels, form.black, torch.ones(pixels.shape[1:], dtype=torch.bool))
    pixels = pixels if light is None else _across(light, axes).without(pixels)
    even = [] if light is None else [form.restored(pixels)]
    down, across = _whole_periods(pixels, axes) if crop else (slice(0, side) for side in pixels.shape[1:])
    exemplar = Exemplar.of([pixels[:, down, across].contiguous()])
    sewing = _sewn(exemplar, (("y" in axes), ("x" in axes)), band, seed, report)
    report("blending", 1.0)
    places = sewing.places.numpy() + np.array([down.start, across.start])[:, None, None]
    where = np.concatenate([np.zeros_like(places[:1]), places])
    patches, smooth = sewing.patches(), sewing.blended()
    spread = ((smooth - patches).abs().amax(0) > SLIGHT).numpy()
    result = Result(torch.from_numpy(np.where(spread, smooth, patches)), torch.from_numpy(where),
                    torch.from_numpy(where[1:]), [], [], "the seams are closed")  # fmt: skip
    tiled = Synthesis(image, where, result, form).take(image)
    anew = spread | bool(even)
    planes_of(tiled)[:, anew] = planes_of(form.restored(result.image))[:, anew]
    return Synthesis(tiled, where, result, form, even=even)


def _across(light: Light, axes: str) -> Light:
    """What of a light changes along the axes, across whose borders it has to go on."""
    changing = light.field
    for axis, name in enumerate("yx"):
        if name not in axes:
            changing = changing - changing.mean(1 - axis, keepdim=True)
    return replace(light, field=changing)


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


def _sewn(picture: Exemplar, closed: tuple[bool, bool], band: int | None, seed: int, report: Report) -> Sewing:
    """A picture sewn to itself; a large one where it is coarser, and then at full resolution as there."""
    seen, factor = picture.halved_to(LAID_FINE)
    band = _band_of(picture, band, factor)
    if band < factor * NARROWEST:
        seen, factor = picture, 1
    borders = _Borders(seen, closed, band // factor, seed)
    first = borders.sew(lambda part: report("sewing", part if factor == 1 else part / 2))
    if factor == 1:
        return first
    fine = _Borders(picture, closed, band, seed).sewing
    fine.follow(first, factor, lambda part: report("sewing", (1 + part) / 2))
    return fine


def _band_of(picture: Exemplar, band: int | None, factor: int) -> int:
    """The band's width, checked against the sides of the picture, which is sewn a factor coarser."""
    height, width = picture.extent
    if min(height, width) < LEAST:
        raise InputError(f"the picture is {width}x{height}; at least {LEAST}x{LEAST} are needed to tile it")
    most = min(height, width) // 4
    if band is None:
        wanted = max(round(element_size(picture)), NARROWEST)
        return min(wanted, factor * WIDEST, max(min(height, width) // PART, 4))
    if not (is_whole(band, 2) and band <= most):
        raise InputError(
            f"the band is {band} pixels; of {width}x{height} it is a whole number from 2 to {most}, a quarter of a side"
        )
    return int(band)


class _Borders:
    """A picture that is sewn to itself along the borders that are closed, and the patches that cover them."""

    def __init__(self, picture: Exemplar, closed: tuple[bool, bool], band: int, seed: int) -> None:
        self.band, self.generator = band, generator_of(seed)
        self.sewing = Sewing(picture, picture.extent, NEAR, closed)
        self._lay_picture()

    def _lay_picture(self) -> None:
        """The picture in its place, but for what is next to the seams; its inside stays."""
        cleared = max(self.band // CLEARED, 1)
        halves = [[(cleared * wraps, n // 2), (n // 2, n - cleared * wraps)] for n, wraps in self._axes]
        for top, bottom in halves[0]:
            for left, right in halves[1]:
                self.sewing.lay_picture(Box((top, left), (bottom - top, right - left)))
        inside = tuple(slice(self.band * wraps, n - self.band * wraps) for n, wraps in self._axes)
        self.sewing.sheet.fixed[inside] = True

    @property
    def _axes(self) -> list[tuple[int, bool]]:
        return list(zip(self.sewing.shape, self.sewing.closed, strict=True))

    def sew(self, report: Callable[[float], None]) -> Sewing:
        """Cover the seams, then try all patches again."""
        self.sewing.sew(list(self._stations()), 1 + MENDING, report)
        return self.sewing

    def _stations(self) -> Iterator[Box]:
        """Boxes as deep as the band on both sides of a seam, half over each other: where seams cross, then along them.

        The first lies somewhere, as drawn. They are as wide as deep, or slim where lines of the texture run across.
        """
        deep = 2 * self.band
        if all(self.sewing.closed):
            yield self._box((-self.band,) * 2, (deep,) * 2)
        for across, along in ((0, 1), (1, 0)):
            if not self.sewing.closed[across]:
                continue
            lines = across if self.sewing.runs == across else None
            extent = drawn_sides(deep, lines, 1.0, SLIM, SLIMMEST)
            wide, (length, wraps) = extent[along], self._axes[along]
            step = wide // 2
            count = math.ceil((length if wraps else length - wide) / step) + (not wraps)
            first = int(torch.randint(step, (1,), generator=self.generator)) if wraps else 0
            for number in range(count):
                start = first + number * length // count if wraps else (length - wide) * number // max(count - 1, 1)
                yield self._box((-self.band, start) if across == 0 else (start, -self.band), extent)

    def _box(self, corner: tuple[int, int], extent: tuple[int, int]) -> Box:
        return Box(corner, extent).clipped(self.sewing.shape, self.sewing.closed)
