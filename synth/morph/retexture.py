"""Morph targets: what a metamorphosis shows in between, made texture again.

A warp or a blend of two textures is soft or doubled in between. Here frame t is only a target: soft pixels, wanted the
more the surer the morph is of them. The texture comes from A and B themselves, both in one source, their colors moved
to those of time t. Each frame starts from the one before: the places its pixels were copied from are carried along the
morph's own velocity, so the film does not boil.
"""

from dataclasses import dataclass, replace

import torch
from scipy.ndimage import gaussian_filter
from torch import Tensor

from flow.animation.carrying import carried
from flow.warps import Lookup, filled, pixel_coordinates, warp
from flow.warps.integration import displacement, jacobian
from kwatra import Exemplar, InputError, Level, Result, Settings, SoftPixels, optimize
from kwatra.base import mean
from synth.morph.method import Film, Pair, Report
from synth.morph.recolor import Colors, recolored

_FLAT = 0.05


@dataclass
class Retexture:
    """How to make a film's frames texture again.

    weight: what the target counts beside the texture where the morph is sure of it. levels: of the engine, at full
    resolution: what the target shows in the large is to stay.
    """

    weight: float = 0.3
    levels: tuple[Level, ...] = (Level(1, 16, 2), Level(1, 8, 2))
    copies: bool = False
    bands: bool = True

    def __call__(self, pair: Pair, film: Film, seed: int, report: Report) -> Film:
        """The film with its frames made anew; A and B themselves stay as they are."""
        sources = Sources.of(pair)
        frames: list[Tensor] = []
        where: Tensor | None = None
        before = 0.0
        for number, (frame, time) in enumerate(zip(film.frames, film.times, strict=True)):
            exemplar = sources.at(time)
            if time in (0, 1):
                where, shown = sources.whole(int(time), frame.shape[1:]), frame
            else:
                term = morph_target(film, pair, number, self.weight)
                start = frame if where is None else sources.start(exemplar, where, film, before, time, pair.tile)
                settings = Settings(levels=self.levels, wrap=pair.tile)
                result = optimize(
                    exemplar,
                    tuple(frame.shape[1:]),
                    settings=settings,
                    terms=term,
                    start=start,
                    seed=seed,
                    between=Bands.of(pair).at(time) if self.bands else None,
                )
                where = result.where.flip(0).float()
                shown = result.image if not self.copies else exemplar.canvas[:, result.where[0], result.where[1]]
            frames.append(shown.clamp(0, 1))
            before = time
            report(f"texture of frame {number + 1} of {len(film.frames)}", (number + 1) / len(film.frames))
        return replace(film, frames=tuple(frames))


def morph_target(film: Film, pair: Pair, number: int, weight: float = 0.3) -> SoftPixels:
    """A frame of a film as a term: soft pixels, of `weight` where the morph is sure of what it shows."""
    sure = sureness(film, pair, film.times[number])
    return SoftPixels(film.frames[number], weight * sure[None], "morph")


def sureness(film: Film, pair: Pair, time: float) -> Tensor:
    """How sure (H, W) a film is of what it shows at a time, 0 to 1.

    Less where the source term does much, that is where what comes from A and what goes to B differ when both have the
    colors of the time, and where maps stretch or squeeze. 1 everywhere for films without a velocity.
    """
    if film.velocity is None:
        return torch.ones_like(film.frames[0][0])
    ways = [displacement(film.velocity, time, end, pair.tile) for end in (0, 1)]
    pixels = pixel_coordinates(ways[0].shape[1:], ways[0].device)
    shown = Sources.of(pair).images(time)
    a, b = (warp(image, pixels + way, wrap=pair.tile) for image, way in zip(shown, ways, strict=True))
    unlike = (a - b).square().mean(0) / mean(shown[0] - mean(shown[0])).square().clamp(min=1e-6)
    variance = mean((shown[0] - mean(shown[0])).square()).clamp(min=1e-4)
    unlike = (a - b).square().mean(0) / variance
    stretched = sum(jacobian(way, pair.tile).clamp(min=_FLAT).log().square() for way in ways)
    return 1 / (1 + unlike + stretched)


@dataclass(frozen=True)
class Bands:
    a: list
    b: list

    @classmethod
    def of(cls, pair):
        return cls([Colors.of(x) for x in split(pair.a)], [Colors.of(x) for x in split(pair.b)])

    def at(self, time):
        goals = [a.toward(b, time) for a, b in zip(self.a, self.b)]

        def between(image, exemplar):
            return torch.stack([recolored(x, Colors.of(x), g) for x, g in zip(split(image), goals)]).sum(0)

        return between


def split(image):
    bands, rest = [], image
    for s in (1, 2, 4):
        low = torch.from_numpy(gaussian_filter(rest.numpy(), (0, s, s)))
        bands.append(rest - low)
        rest = low
    return [*bands, rest]


@dataclass(frozen=True)
class Sources:
    """A and B as what is copied from, at any time: their colors are those of the time."""

    a: Tensor
    b: Tensor
    colors_a: Colors
    colors_b: Colors

    @classmethod
    def of(cls, pair: Pair) -> "Sources":
        return cls(pair.a, pair.b, Colors.of(pair.a), Colors.of(pair.b))

    def images(self, time: float) -> tuple[Tensor, Tensor]:
        return (
            recolored(self.a, self.colors_a, self.colors_b, time).clamp(0, 1),
            recolored(self.b, self.colors_b, self.colors_a, 1 - time).clamp(0, 1),
        )

    def at(self, time: float) -> Exemplar:
        return Exemplar.of(list(self.images(time)), device=self.a.device)

    def whole(self, number: int, shape) -> Tensor:
        """Source coordinates (2, H, W) of the whole image."""
        exemplar = self.at(float(number))
        first = ((exemplar.origin[0] == number) & (exemplar.owner >= 0)).nonzero()[0]
        return pixel_coordinates(shape, self.a.device) + first.flip(0).view(2, 1, 1)

    def start(self, exemplar: Exemplar, where: Tensor, film: Film, before: float, time: float, wrap: bool) -> Tensor:
        """The frame before at this time: its copies moved, in the colors of now."""
        pixels = pixel_coordinates(where.shape[1:], where.device)
        if film.velocity is not None:
            place = pixels + displacement(film.velocity, time, before, wrap)
            where = carried(where, Lookup(place, torch.ones_like(place[0], dtype=torch.bool)))
        return warp(filled(exemplar.canvas, exemplar.owner >= 0), where)
