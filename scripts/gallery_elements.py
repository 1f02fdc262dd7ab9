"""Metamorphoses of elements, after figures of Liu et al. 2002 and of Tonietto and Walter 2005.

Problem: both textures are made of elements, and every element of A is to become one of B. Liu's way: landmarks of all
patterns, paired by the least sum of squared ways (their equation 7), and a warp through them. Tonietto and Walter's:
texture of both under a film of masks. The textures are made here; the papers' own are not ours to show.

    python scripts/gallery_elements.py [--out out/elements] [--side 96]
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from bench_patterns import made
from exemplars import pebbles
from gallery_quilting import RGB, beside
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from torch import Tensor

from synth import write_image
from synth.metamorphosis.method import Method, Pair
from synth.metamorphosis.patterns import PatternMorph, Patterns, detect, drawn, patterns_of
from synth.metamorphosis.textons import MovingMasks, TextonMorph

TIMES = (0.0, 0.25, 0.5, 0.75, 1.0)
PITCH, RADIUS = 24, 7.0
CORNERS = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
MIDDLES = np.array([[0.0, -1], [1, 0], [0, 1], [-1, 0]])
WARM, COLD, PALE, DARK = (0.8, 0.3, 0.2), (0.25, 0.4, 0.8), (0.92, 0.88, 0.8), (0.15, 0.15, 0.2)


def centers(side: int, pitch: int = PITCH) -> NDArray[np.float64]:
    x, y = np.meshgrid(np.arange(pitch / 2, side, pitch), np.arange(pitch / 2, side, pitch))
    return np.stack([x, y], -1).reshape(-1, 2)


def texture(
    places: NDArray[np.float64], side: int, square: bool, inside: Sequence[float], outside: Sequence[float]
) -> Tensor:
    """Discs or squares at places (n, 2), with a little noise: (3, side, side)."""
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    covered = np.zeros((side, side))
    for cx, cy in places:
        away = np.maximum(abs(x - cx), abs(y - cy)) if square else np.hypot(x - cx, y - cy)
        covered = np.maximum(covered, np.clip(RADIUS + 0.5 - away, 0, 1))
    colors = np.multiply.outer(inside, covered) + np.multiply.outer(outside, 1 - covered)
    noise = np.random.default_rng(0).normal(0, 0.03, colors.shape)
    return torch.from_numpy((colors + noise).clip(0, 1)).float()


def film(method: Method, a: Tensor, b: Tensor) -> Tensor:
    """Five frames beside each other."""
    return beside(*method(Pair(a, b), TIMES, 0, lambda what, part: None).frames)


def below(*rows: Tensor) -> Tensor:
    """Pictures (3, H, W) of one width below each other."""
    return torch.cat(rows, 1)


def discs_and_squares(side: int) -> tuple[Tensor, Tensor]:
    return texture(centers(side), side, False, WARM, PALE), texture(centers(side), side, True, COLD, DARK)


def spots(side: int) -> Tensor:
    """Dark spots of any shape on light fur, (3, side, side)."""
    rough = gaussian_filter(np.random.default_rng(3).normal(size=(side, side)), 4, mode="wrap")
    inside = 1 / (1 + np.exp(-60 * (rough - 0.6 * rough.std()) / rough.std() / 4))
    colors = np.multiply.outer(DARK, inside) + np.multiply.outer((0.8, 0.62, 0.35), 1 - inside)
    noise = np.random.default_rng(0).normal(0, 0.03, colors.shape)
    return torch.from_numpy((colors + noise).clip(0, 1)).float()


def mixed(side: int) -> Tensor:
    """Discs and squares by turns, (3, side, side)."""
    discs = texture(_by_turns(side), side, False, WARM, PALE)
    return torch.minimum(discs, texture(_by_turns(side, 1), side, True, COLD, PALE))


def chosen(side: int) -> tuple[Patterns, Patterns, Patterns]:
    """A square of the source, and of discs and squares by turns a disc and a square: eight landmarks each."""
    square, angles = np.stack([CORNERS, MIDDLES], 1).reshape(-1, 2), (np.arange(8) - 3) / 4 * np.pi
    disc = np.stack([np.cos(angles), np.sin(angles)], 1)
    own, shapes = centers(side)[0], [(centers(side)[0], disc), (centers(side)[1], square)]
    target = [Patterns((side, side), place + RADIUS * shape) for place, shape in shapes]
    return Patterns((side, side), own + RADIUS * square), target[0], target[1]


def liu_1(side: int) -> Tensor:
    """Stones become other stones."""
    return film(PatternMorph(), pebbles(side), pebbles(side, 1))


def liu_3(side: int) -> Tensor:
    """The patterns found in both textures."""
    return beside(*(drawn(image, _found(image)) for image in discs_and_squares(side)))


def liu_4(side: int) -> Tensor:
    """A texture, the votes for centroids, and the candidates among them."""
    texture = made("cross", size=max(side, 96))
    detection = detect(texture.image, texture.landmarks[0])
    image = torch.from_numpy(texture.image).permute(2, 0, 1).float()
    votes = torch.from_numpy(detection.votes / detection.votes.max()).float().expand(3, -1, -1)
    marked = image.clone()
    for x, y in detection.candidates.astype(int):
        marked[:, max(0, y - 1) : y + 2, max(0, x - 1) : x + 2] = torch.tensor([1.0, 0, 1]).view(3, 1, 1)
    return beside(image, 1 - votes, marked)


def liu_5(side: int) -> Tensor:
    """The same places, and other shapes; below, more elements in B than in A."""
    a, b = discs_and_squares(side)
    fewer = texture(np.delete(centers(side), [1, 6], 0), side, False, WARM, PALE)
    return below(film(PatternMorph(), a, b), film(PatternMorph(), fewer, b))


def liu_6(side: int) -> Tensor:
    """A pattern of the source, and two of which either may be the target's; what is detected for each."""
    a, b = texture(_by_turns(side), side, True, WARM, PALE), mixed(side)
    return beside(*(drawn(image, _like(image, one)) for image, one in zip((a, b, b), chosen(side), strict=True)))


def liu_7(side: int) -> Tensor:
    """The films to the one pattern and to the other."""
    a, b = texture(_by_turns(side), side, True, WARM, PALE), mixed(side)
    own, disc, square = chosen(side)
    return below(*(film(PatternMorph(own, other), a, b) for other in (disc, square)))


def liu_8(side: int) -> Tensor:
    """Squares to squares by four landmarks and by eight; in the second and fourth row the order turns them."""
    a = texture(centers(side), side, True, WARM, PALE)
    rows = []
    for shape in (CORNERS, np.stack([CORNERS, MIDDLES], 1).reshape(-1, 2)):
        for turn in (0, len(shape) // 4):
            every = centers(side)[:, None] + RADIUS * shape
            straight, turned = (Patterns((side, side), each[0], each) for each in (every, np.roll(every, turn, 1)))
            rows.append(film(PatternMorph(straight, turned), a, a))
    return below(*rows)


def tonietto_walter_6(side: int) -> Tensor:
    """What goes in: both textures and their masks."""
    pair = Pair(*discs_and_squares(side))
    masks = (torch.from_numpy(mask).float().expand(3, -1, -1) for mask in TextonMorph().masks(pair))
    return beside(pair.a, pair.b, *masks)


def tonietto_walter_7(side: int) -> Tensor:
    """The masks on their way."""
    masks = TextonMorph().masks(Pair(*discs_and_squares(side)))
    moving = MovingMasks.of(*masks)
    return beside(*(torch.from_numpy(moving.at(t)).float().expand(3, -1, -1) for t in TIMES))


def tonietto_walter_9(side: int) -> Tensor:
    """By the engine."""
    return film(TextonMorph(), *discs_and_squares(side))


def tonietto_walter_9_published(side: int) -> Tensor:
    """Pixel by pixel as published; it takes a minute."""
    return film(TextonMorph(published=True, window_a=7, window_b=9), *discs_and_squares(side))


def tonietto_walter_10(side: int) -> Tensor:
    """The cross-dissolve, to compare with."""
    a, b = discs_and_squares(side)
    return beside(*(torch.lerp(a, b, t) for t in TIMES))


def tonietto_walter_11(side: int) -> Tensor:
    """From a lattice to the fur of a cheetah."""
    return film(TextonMorph(), texture(centers(side), side, True, COLD, PALE), spots(side))


def _by_turns(side: int, rest: int = 0) -> NDArray[np.float64]:
    """Every second place of the lattice, or with a rest of 1 the others."""
    places = centers(side)
    return places[(places // PITCH).sum(1) % 2 == rest]


def _like(image: Tensor, one: Patterns) -> Patterns:
    return patterns_of(image.permute(1, 2, 0).double().numpy(), one).patterns


def _found(image: Tensor) -> Patterns:
    return patterns_of(image.permute(1, 2, 0).double().numpy()).patterns


FIGURES = (
    liu_1,
    liu_3,
    liu_4,
    liu_5,
    liu_6,
    liu_7,
    liu_8,
    tonietto_walter_6,
    tonietto_walter_7,
    tonietto_walter_9,
    tonietto_walter_9_published,
    tonietto_walter_10,
    tonietto_walter_11,
)


def main(arguments: list[str] | None = None) -> None:
    """Draw all figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/elements"))
    parser.add_argument("--side", type=int, default=96)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    for figure in FIGURES:
        write_image(options.out / f"{figure.__name__}.png", figure(options.side), RGB, overwrite=True)
        print(figure.__name__, figure.__doc__)


if __name__ == "__main__":
    main()
