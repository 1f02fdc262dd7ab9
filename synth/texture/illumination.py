"""Light that falls unevenly on a still: found, taken out before blocks of it are laid side by side, and put back.

Values are those of an evenly lit texture times light, as in a shadow, or plus light, as in a gloss. The more light
differs over the picture, the more it blurs their histogram, so it is that polynomial of the place with whose removal
the histogram is sharpest, as the uneven fields of magnetic resonance images are found (Sled, Zijdenbos and Evans 1998,
"A nonparametric method for automatic correction of intensity nonuniformity in MRI data"). That is the b with the
largest likelihood

    sum_p log f(r_p),    r_p = y_p - b . B(p),    y = log v, or v,

where f is the blurred histogram of the r themselves, of whatever shape. It is climbed by Fisher's steps, b += mean_p
s_p B(p) / J with the scores s = -f'/f and the information J, the mean of s^2; B are orthonormal over the picture.

Elements that happen to be dark on one side look like light, too, but where they do, their tones vary as much on smaller
scales. So light is believed where its coefficients of the degrees 1 and 2 are large, and large beside those that one
more step would give to the degrees 3 to 6; and where it falls on all colors alike, as a thing of a color of its own
does not.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra import Exemplar
from synth.texture.polynomials import FULL, Basis

BELIEVED = 0.7
"""Light is believed whose standard deviation, in log v, times the root of how many times its coefficients are as large
in the mean square as those of degrees 3 to 6 is more. Of 50 textures that are lit evenly it is .29 at most, and .16 of
made clouds, planks, marble and hides; of twelve under gradients from .6 to 1.4, vignettes and soft shadows 1.05 to 9.7,
of scikit-image's page and coins 4.8 and 5.0. Of 90 crops of 128 pixels none is taken for lit unevenly, of 158 of 96 two
and of 162 of 64 three, of planks, clouds and stones of which little is seen. Of 81 textures lit by .85 to 1.15 35 are
found, by .75 to 1.25 72, by .6 to 1.4 80."""

PLAIN = 2
"""Degree of the polynomials by which light is looked for; that of those by which it is taken out is
`polynomials.FULL`."""

BLUR = 0.15
"""Histograms are blurred by so many standard deviations of their values, over which light is seen by its slope: with .1
of .3 little changes."""

BINS, STEPS, STILL = 8, 25, 2e-3
"""Bins of a histogram for each deviation it is blurred by; steps at most; and none of that length is the last."""

TINTED = 2.0
"""Light differs at most so many times as much in one color as in another; what does more is a thing of another color.
Of 41 textures in color under four lights, each alike for all, it is 1.03 times in the median and 2 at most; where blue
differs by a quarter more and red less, 1.66, and below 1.8 of nine in ten. Of crops of a retina, which was made to
glow, it is 2.6 to 12, of dyed tissue up to 2.5, of a red cup on wood 1.4 to 9, of the sky at dusk 1.3 to 3.5."""

LOOKED_AT, LEAST = 2**16, 64
"""So many pixels of a picture at most are looked at; and smaller ones are not: of few elements all may be chance."""

FLOOR, BRIGHT = 0.02, 0.99
"""Values below so much of the brightest, which so many of them are below, count as that: logarithms have no end."""


@dataclass(frozen=True, eq=False)
class Light:
    """Light on a picture: `field` (H, W) float32, 0 where it is as on average, of log v if it `times` v, else of v.

    black: what normalized values lack of v, which is 0 where no light is. colors: on so many channels, the first.
    """

    field: Tensor
    times: bool
    black: float
    colors: int

    def without(self, picture: Tensor) -> Tensor:
        """A picture (C, H, W), as it would be under even light; values stay within [0, 1]."""
        return self._moved(picture, -self.field).clamp(0, 1)

    def upon(self, picture: Tensor) -> Tensor:
        """A picture (C, H, W) of even light, under this one."""
        return self._moved(picture, self.field)

    def at(self, place: Sequence[Tensor]) -> "Light":
        """That on places (2, n) of the picture, the nearest of it for those outside."""
        near = tuple(p.clamp(0, size - 1) for p, size in zip(place, self.field.shape, strict=True))
        return replace(self, field=self.field[near])

    def _moved(self, picture: Tensor, field: Tensor) -> Tensor:
        lit = picture[: self.colors]
        lit = (lit + self.black) * field.exp() - self.black if self.times else lit + field
        return torch.cat([lit, picture[self.colors :]])


def under_even_light(exemplar: Exemplar, black: float) -> Exemplar:
    """The exemplar without the light on its images and their variants; itself where all are lit evenly, or are clips.

    black: see `Light`.
    """
    canvas = exemplar.canvas
    for box, inside in exemplar.places():
        light = find_light(exemplar.canvas[(slice(None), *box)], black, inside)
        if light is not None:
            first = inside.nonzero()[0]
            number, *seen = exemplar.origin[(slice(None), *box)][:, first[0], first[1]]
            mine = (exemplar.origin[0] == number) & (exemplar.owner >= 0)
            place = [axis[mine] - its + at for axis, its, at in zip(exemplar.origin[1:], seen, first, strict=True)]
            canvas = canvas.clone() if canvas is exemplar.canvas else canvas
            canvas[:, mine] = light.at(place).without(canvas[:, mine])
    return exemplar if canvas is exemplar.canvas else replace(exemplar, canvas=canvas)


def find_light(picture: Tensor, black: float, known: Tensor) -> Light | None:
    """The light on a picture (C, H, W) in [0, 1], where it is known (H, W); None where that cannot be told from even.

    black: see `Light`. Looked for on stills, gray or of three colors, with or without one channel more that is the same
    everywhere, as alpha of what is opaque is: what else has channels need not be lit.
    """
    step = math.ceil(math.sqrt(max(known.numel() / LOOKED_AT, 1)))
    there = known.cpu().numpy()
    some = there[::step, ::step]
    colors = _colors(picture[:, known.to(picture.device)]) if known.ndim == 2 else 0
    if colors == 0 or min(known.shape) < LEAST or np.count_nonzero(some) < LEAST**2:
        return None
    values = picture[:colors].double().mean(0).cpu().numpy() + black
    lit = values[::step, ::step][some]
    unit = float(np.quantile(lit, BRIGHT)) or 1.0
    basis = Basis.over(some)
    told = _told(lit / unit, basis)
    if told is None:
        return None
    light, times = told
    if not _of_one_color(picture[:colors].cpu().numpy()[:, ::step, ::step][:, some] + black, unit, told, basis):
        return None
    shape = basis.legendre(light if there.all() else basis.calmed(light))
    field = Basis.field(shape, known.shape) * (1.0 if times else unit)
    field = field.clip(field[there].min(), field[there].max())
    whole = values[there]
    if times:
        field += np.log((whole * np.exp(-field[there])).mean() / whole.mean())
    else:
        field -= field[there].mean()
    return Light(torch.from_numpy(field).float().to(picture.device), times, black, colors)


def _colors(pixels: Tensor) -> int:
    """How many of the channels of pixels (C, n) are colors that light falls on; 0 where that is not clear."""
    opaque = len(pixels) in (2, 4) and pixels.numel() > 0 and bool((pixels[-1] == pixels[-1, 0]).all())
    return len(pixels) - opaque if len(pixels) - opaque in (1, 3) else 0


def _told(values: Any, basis: Basis) -> tuple[Any, bool] | None:
    """The light that values (n,) show, as coefficients (k,) of the basis, and whether it times them.

    None where it is not to be believed.
    """
    logs = np.log(np.maximum(values, FLOOR))
    found = _sharpest(logs, basis, PLAIN)
    if found is None or found.evidence < BELIEVED:
        return None
    shade, gloss = _sharpest(logs, basis, FULL), _sharpest(values, basis, FULL)
    if shade is None or gloss is None:
        return None
    added = _adds(values, logs, basis.on(shade.light), basis.on(gloss.light))
    return (gloss if added else shade).light, not added


def _adds(values: Any, logs: Any, shade: Any, gloss: Any) -> bool:
    """Whether light adds gloss (n,) to values (n,), and does not times them by exp(shade).

    It does if values are likelier so, by the histogram of what they are without light and by that of its logarithms,
    each of which is blurred where the other is sharp. Of 197 textures times light one is mistaken so, of 201 with light
    added none; by the histogram each light was found by, 13 and half of them were.
    """
    plain, matte = np.exp(logs - shade), np.maximum(values - gloss, FLOOR)
    by_values = _scores(values - gloss)[2] - _scores(plain)[2] + shade.mean()
    by_logs = _scores(np.log(matte))[2] - np.log(matte).mean() - _scores(logs - shade)[2] + logs.mean()
    return min(by_values, by_logs) > 0


def _of_one_color(pixels: Any, unit: float, told: tuple[Any, bool], basis: Basis) -> bool:
    """Whether light as told by pixels (C, n), in units of that, differs as much in one color as in another."""
    light, times = told
    field, colors = basis.on(light), pixels / unit
    much = np.einsum("n,cn->c", field - field.mean(), np.log(np.maximum(colors, FLOOR)) if times else colors)
    return bool(0 < much.max() <= TINTED * much.min())


class _Fit(NamedTuple):
    """Coefficients of light, and how much it is to be believed."""

    light: Any
    evidence: float


def _sharpest(values: Any, basis: Basis, degree: int) -> _Fit | None:
    """The light of a degree without which values (n,) have the sharpest histogram; None of values that are all one."""
    low = (basis.degrees > 0) & (basis.degrees <= degree)
    light = np.zeros(len(low))
    for _ in range(STEPS):
        scores, information, _ = _scores(values - basis.on(light))
        if information == 0:
            return None
        step = np.einsum("kn,n->k", basis.at, scores) / (len(values) * information)
        light[low] += step[low]
        if np.abs(step[low]).max() < STILL:
            break
    beside = np.square(step[basis.degrees > degree]).mean()
    power = np.square(light[low])
    return _Fit(light, float(np.sqrt(power.sum() * power.mean() / max(beside, 1e-12))))


def _scores(rest: Any) -> tuple[Any, float, float]:
    """Scores -f'/f of values (n,) in their blurred histogram f, the information, and the mean log f; 0 of one value."""
    spread = float(rest.std())
    if spread < 1e-6:
        return np.zeros(len(rest)), 0.0, 0.0
    bin_ = BLUR * spread / BINS
    place = (rest - rest.min()) / bin_ + 4 * BINS
    low = place.astype(np.int64)
    part, size = place - low, int(low.max()) + 4 * BINS
    count = np.bincount(low, 1 - part, size) + np.bincount(low + 1, part, size)
    density, slope = (
        ndimage.gaussian_filter1d(count, BINS, order=order, mode="constant") / (len(rest) * bin_ ** (1 + order))
        for order in (0, 1)
    )
    curve = -slope / (density + 1e-3 * density.max())
    information = -float((slope * curve).sum() / density.sum())
    scores = curve[low] * (1 - part) + curve[low + 1] * part
    likelihood = np.log(density[low] * (1 - part) + density[low + 1] * part).mean()
    return scores - scores.mean(), information, float(likelihood)
