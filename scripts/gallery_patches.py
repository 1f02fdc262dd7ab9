"""Textures in between, after the figures of Ruiters, Schnabel and Klein, Patch-based Texture Interpolation, 2010.

Problem: what lies between two textures is a texture too, though no warp leads from one to the other. It is made of
neighborhoods of both that were warped onto each other and blended, N(x) = (1 - t) N_1(x + u_1) + t N_2(x + u_2).

The exemplars are scikit-image's brick, gravel and grass, and stones made here; the paper's own are not ours to show,
the same points are made. Other pairs are shown with --pair: --pair a.png b.png --out out/mine.
"""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

import torch
from exemplars import brick, gravel, pebbles
from gallery_flow import colored
from gallery_quilting import RGB, beside
from skimage import data
from tables import halved
from torch import Tensor

import synth
from synth import read_image, write_image

Pair = tuple[Tensor, Tensor]


def stills(pair: Pair, times: Sequence[float], **how: object) -> Tensor:
    """Textures at some times, each made by itself, beside each other."""
    made = synth.morph(*pair, times, method="patches", independent=True, **how)
    return beside(*map(colored, made.frames))


def figure_1(pair: Pair) -> Tensor:
    """At t = 0.4: blended, warped and blended, neighborhoods blended in place, and neighborhoods warped and blended."""
    shown = [synth.morph(*pair, [0.4], method=method).frames[0] for method in ("blend", "registration")]
    return beside(*map(colored, shown), *(stills(pair, [0.4], warped=warped) for warped in (False, True)))


def figure_2(pair: Pair) -> Tensor:
    """Windows on a grid, and where they fit best."""
    return beside(*(stills(pair, [0.5], free_centers=free) for free in (False, True)))


def figure_3(pair: Pair) -> Tensor:
    """Without relaxation and statistics, with relaxation, and with both."""
    kinds = ((False, False), (True, False), (True, True))
    return beside(*(stills(pair, [0.5], relaxed=relaxed, statistics=kept) for relaxed, kept in kinds))


def figure_4(pair: Pair) -> Tensor:
    """A strip on which t runs from 0 to 1."""
    height, width = pair[0].shape[1:]
    ramp = torch.linspace(0, 1, 4 * width).expand(height, -1)
    return colored(synth.interpolate(list(pair), [ramp]).image)


def figure_5(pair: Pair) -> Tensor:
    """A, the texture halfway, and B."""
    return beside(colored(pair[0]), stills(pair, [0.5]), colored(pair[1]))


def figure_7(pair: Pair) -> Tensor:
    """A picture as a map of t: rings, a ramp and sharp borders. Features run on across them."""
    side = 2 * pair[0].shape[1]
    line = torch.linspace(-1, 1, side)
    far = (line[:, None].square() + line.square()).sqrt()
    rings = torch.where(far < 0.9, 0.5 + 0.5 * torch.cos(2.2 * torch.pi * far), (line + 1).div(2).expand(side, -1))
    return beside(colored(rings[None]), colored(synth.interpolate(list(pair), [rings]).image))


def figure_film(pair: Pair) -> Tensor:
    """The six frames of a film that begins in A and ends in B."""
    return beside(*map(colored, synth.morph(*pair, 6, method="patches").frames))


def figure_triangle(pair: Pair) -> Tensor:
    """Three textures: one above, two below, and all that lies between them."""
    side = pair[0].shape[1]
    third = colored(pebbles(side, 3))
    y, x = torch.meshgrid(torch.linspace(0, 1, 2 * side), torch.linspace(0, 1, 2 * side), indexing="ij")
    weights = torch.stack([1 - y, y * (1 - x), y * x])
    return synth.interpolate([*map(colored, pair), third], [weights]).image


FIGURES: tuple[Callable[[Pair], Tensor], ...] = (
    figure_1, figure_2, figure_3, figure_4, figure_5, figure_7, figure_film, figure_triangle,
)  # fmt: skip


def pairs(side: int) -> dict[str, Pair]:
    """Pairs of exemplars by name."""
    grass = torch.from_numpy(halved(data.grass())[:side, :side].copy())[None].float() / 255
    stones = pebbles(side, 0), pebbles(side, 1)
    return {"brick_gravel": (brick(side), gravel(side)), "stones": stones, "gravel_grass": (gravel(side), grass)}


def main(words: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=128, help="side of the exemplars and the frames")
    parser.add_argument("--pair", type=Path, nargs=2, metavar=("A", "B"), help="two images instead")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="these figures alone: 1, 2, ... film or triangle")
    parser.add_argument("--out", type=Path, default=Path("out/gallery_patches"), help="folder for the pictures")
    arguments = parser.parse_args(words)
    arguments.out.mkdir(parents=True, exist_ok=True)
    shown = pairs(arguments.side)
    if arguments.pair is not None:
        a, b = (read_image(path).pixels for path in arguments.pair)
        shown = {arguments.pair[0].stem: (a, b)}
    for figure in FIGURES:
        name = figure.__name__.split("_")[1]
        for pair, textures in shown.items():
            if arguments.only is None or name in arguments.only:
                path = arguments.out / f"figure_{name}_{pair}.png"
                write_image(path, figure(textures).clamp(0, 1), RGB, overwrite=True)
                print(f"{path}: {figure.__doc__}", flush=True)


if __name__ == "__main__":
    main()
