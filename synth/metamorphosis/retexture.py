"""Morph targets: what a metamorphosis shows in between, made texture again.

A warp or a blend of two textures is soft or doubled in between. Here frame t is only a target: soft pixels, wanted the
more the surer the morph is of them. The texture comes from A and B themselves, both in one source, their colors moved
to those of time t, so that a patch of A beside one of B does not show by its color; and details get back, after each
blend, the strength they have at time t (`bands`). Each frame starts from the one before: the places its pixels were
copied from are carried along the morph's own velocity, so that the film does not boil.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from flow.animation.carrying import carried
from flow.warps import Lookup, displacement, filled, jacobian, pixel_coordinates, warp
from kwatra import Exemplar, Level, Settings, SoftPixels, optimize
from kwatra.base import InputError, over_channels
from synth.metamorphosis.bands import bands_at
from synth.metamorphosis.method import Film, Frames, Pair, Report
from synth.metamorphosis.recolor import Colors, barycenter, recolored

WEIGHT = 2.5
"""What a target counts beside the texture where the morph is sure of it: tried 0.3 to 6 on the six pairs of `Search`.

Less lets the film flicker, more leaves what is doubled or torn in the target as it is.
"""

_FLAT = 0.05
"""Areas count as no less than this: squeezed farther, a pixel is as unsure as can be."""


@dataclass(frozen=True)
class Retexture:
    """How to make a film's frames texture again.

    weight: see `morph_target`. levels: of the engine, at full resolution: what the target shows in the large stays.
    """

    weight: float = WEIGHT
    levels: tuple[Level, ...] = (Level(1, 16, 2), Level(1, 8, 2))

    def __call__(self, pair: Pair, film: Film, seed: int, report: Report) -> Film:
        """The film with its frames made anew; A and B themselves stay as they are."""
        return replace(film, frames=Frames(self._frames(pair, film, seed, report), len(film.times)))

    def _frames(self, pair: Pair, film: Film, seed: int, report: Report) -> Iterator[Tensor]:
        sources, where = Sources.of(pair), None
        settings = Settings(levels=self.levels, wrap=pair.tile)
        for number, (frame, time) in enumerate(zip(film.frames, film.times, strict=True)):
            report(f"texture of frame {number + 1} of {len(film.times)}", number / len(film.times))
            exemplar = sources.at(time)
            if time in (0, 1):
                where = sources.whole(exemplar, int(time))
                yield frame
                continue
            start = frame
            if where is not None:
                place = carried_along(film, film.times[number - 1], time, where, pair.tile)
                start = warp(filled(exemplar.canvas, exemplar.owner >= 0), place)
            result = optimize(
                exemplar,
                tuple(frame.shape[1:]),
                settings=settings,
                terms=morph_target(film, pair, number, self.weight),
                start=start,
                seed=seed,
                between=bands_at(pair, time).between,
            )
            where = result.where.flip(0).float()
            yield result.image.clamp(0, 1)


PRESETS = {
    "fast": Retexture(levels=(Level(1, 8, 2),)),
    "default": Retexture(),
    "best": Retexture(levels=(Level(1, 16, 4), Level(1, 8, 4))),
}


def morph_target(film: Film, pair: Pair, number: int, weight: float = WEIGHT) -> SoftPixels:
    """Frame `number` of a film as a term of the texture energy, to be combined with any others.

    Soft pixels whose values are the frame's; each counts `weight` times how sure the morph is of it (`sureness`).
    """
    if not 0 <= number < len(film.frames):
        raise InputError(f"the frame is number {number}; the film has frames 0 to {len(film.frames) - 1}")
    sure = sureness(film, pair, film.times[number])
    return SoftPixels(film.frames[number], weight * sure[None], "morph")


def sureness(film: Film, pair: Pair, time: float) -> Tensor:
    """How sure (H, W) a film is of what it shows at a time, from above 0 to 1.

    Less where the source term does much, that is where what comes from A and what goes to B differ though both have
    the colors of the time, and where the maps stretch or squeeze; most so halfway. 1 everywhere at the ends, and for
    films without a velocity.
    """
    if film.velocity is None:
        return torch.ones_like(film.frames[0][0])
    ways = [displacement(film.velocity, time, end, pair.tile) for end in (0, 1)]
    pixels, sources = pixel_coordinates(ways[0].shape[1:], ways[0].device), Sources.of(pair)
    shown = sources.images(time)
    a, b = (warp(image, pixels + way, wrap=pair.tile) for image, way in zip(shown, ways, strict=True))
    between = barycenter((sources.colors_a, sources.colors_b), (1 - time, time))
    variance = float(between.covariance.diagonal().mean())
    unlike = over_channels((a - b).square()) / (len(a) * variance)
    stretched = torch.stack([jacobian(way, pair.tile).clamp(min=_FLAT).log().square() for way in ways]).sum(0)
    return 1 / (1 + 4 * time * (1 - time) * (unlike + stretched))


def carried_along(film: Film, before: float, time: float, where: Tensor, wrap: bool) -> Tensor:
    """Source coordinates (2, H, W), x first, of a frame at time `before`, carried along to `time`."""
    if film.velocity is None:
        return where
    pixels = pixel_coordinates(where.shape[1:], where.device)
    place = pixels + displacement(film.velocity, time, before, wrap)
    return carried(where, Lookup(place, torch.ones_like(place[0], dtype=torch.bool)))


@dataclass(frozen=True)
class Sources:
    """A and B as what is copied from; at any time their colors are those of the time."""

    pair: Pair
    colors_a: Colors
    colors_b: Colors

    @classmethod
    def of(cls, pair: Pair) -> "Sources":
        """Those of a pair."""
        return cls(pair, Colors.of(pair.a), Colors.of(pair.b))

    def images(self, time: float) -> tuple[Tensor, Tensor]:
        """A with its colors a part `time` of the way to B's, and B with the rest of the way to A's."""
        a = recolored(self.pair.a, self.colors_a, self.colors_b, time)
        b = recolored(self.pair.b, self.colors_b, self.colors_a, 1 - time)
        return a.clamp(0, 1), b.clamp(0, 1)

    def at(self, time: float) -> Exemplar:
        """Both on one canvas."""
        return Exemplar.of(list(self.images(time)), device=self.pair.a.device)

    def whole(self, exemplar: Exemplar, number: int) -> Tensor:
        """Source coordinates (2, H, W), x first, of all of A (0) or B (1) on that canvas."""
        row, column = (exemplar.owner == number).nonzero()[0]
        pixels = pixel_coordinates(self.pair.a.shape[1:], self.pair.a.device)
        return pixels + torch.stack([column, row]).view(2, 1, 1)
