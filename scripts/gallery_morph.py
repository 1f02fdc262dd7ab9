"""Metamorphoses, after the figures of Kabul et al., An Optimal Control Approach for Texture Metamorphosis, 2011.

Problem: lead from texture A to texture B so that every frame is a texture. A velocity v moves the picture, a source
term q changes its colors, and both are to be small:

    E(v, q) = |L v|^2 + |q|^2        subject to I_t + DI v = q, I(0) = A, I(1) = B        (equation 1)

The exemplars are scikit-image's brick, gravel, grass, coins and page, and stones, discs and weaves made here; the
paper's own are not ours to show, the same points are made.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

import torch
from exemplars import brick, gravel, pebbles
from gallery_flow import coins, colored, under
from gallery_quilting import RGB, beside, picture, weave
from scipy.ndimage import gaussian_filter
from skimage import data
from torch import Tensor

import flow
import synth
from flow.animation import flow_term
from kwatra import Level, Settings, SoftPixels, optimize
from synth import write_image
from synth.metamorphosis.features import edges
from synth.metamorphosis.method import Pair
from synth.metamorphosis.retexture import Sources, morph_target

TIMES = (0.0, 0.25, 0.5, 0.75, 1.0)
Texture = Callable[[int], Tensor]


def discs(side: int, count: int, radius: float, shift: float = 0.0) -> Tensor:
    """Light discs in rows on dark ground, (1, side, side); radius and shift in parts of their distance."""
    step = side / count
    across = (torch.arange(side) + 0.5) / step - shift
    near = (across - across.floor() - 0.5).square()
    distance = (near[:, None] + near).sqrt()
    return 0.15 + 0.7 * torch.sigmoid((radius - distance) * step)[None]


def film(a: Tensor, b: Tensor, method: str = "control", **how: object) -> Tensor:
    """Five frames of a metamorphosis beside each other."""
    return beside(*map(colored, synth.morph(a, b, TIMES, method=method, **how).frames))


def half(a: Tensor, b: Tensor, method: str = "control", **how: object) -> Tensor:
    return colored(synth.morph(a, b, [0.5], method=method, **how).frames[0])


def figure_4(side: int) -> Tensor:
    """Halfway after 0, 1, 5 and 40 iterations of each level, and below how far each pixel moves until then."""
    a, b = discs(side, 2, 0.36), discs(side, 4, 0.32)
    columns = [(colored(torch.lerp(a, b, 0.5)), torch.ones(3, side, side))]
    for iterations in (1, 5, 40):
        made = synth.morph(a, b, [0.5], method="control", iterations=iterations)
        assert made.film.velocity is not None
        moved = flow.warps.displacement(made.film.velocity, 0, 1)
        columns.append((colored(made.frames[0]), flow.picture(moved, arrows=max(side // 8, 8))))
    return under(*(beside(*row) for row in zip(*columns, strict=True)))


def figure_5(side: int) -> Tensor:
    """Few large discs become many small ones: above a dissolve, below control, which splits them."""
    a, b = discs(side, 2, 0.36), discs(side, 4, 0.32)
    return under(film(a, b, method="blend"), film(a, b))


def figure_7(side: int) -> Tensor:
    """Natural textures: of each pair above a dissolve, below control, by colors alone."""
    grass: Tensor = picture(data.grass(), side)
    pairs = [(gravel(side), grass[:1]), (pebbles(side), pebbles(side, 1)), (brick(side), gravel(side))]
    return under(*(film(a, b, method=name) for a, b in pairs for name in ("blend", "control")))


def figure_8(side: int) -> Tensor:
    """Halfway: a dissolve, control by colors alone, and with features: edges above, below discs whose tones swap."""
    stones, light, dark = pebbles(side), discs(side, 4, 0.4), 1 - discs(side, 4, 0.3, 0.2)
    rows = []
    for a, b, features in (
        (stones, coins(side), (edges(stones), edges(coins(side)))),
        (light, dark, (light, 1 - dark)),
    ):
        plain, marked = half(a, b), half(a, b, features=features, sigma=0.2)
        rows.append(beside(colored(a), half(a, b, method="blend"), plain, marked, colored(b)))
    return under(*rows)


def figure_9(side: int) -> Tensor:
    """Structured textures, dark joints being features: a dissolve, control, control made texture again."""
    a, b = 1 - picture(data.brick(), side), pebbles(side)
    joints = {"features": (dark(a), dark(b)), "sigma": 0.3}
    return under(film(a, b, method="blend"), film(a, b, **joints), film(a, b, retexture=True, **joints))


def dark(image: Tensor) -> Tensor:
    """Where an image (C, H, W) is dark in all channels, (1, H, W), blurred so that it attracts from some px around."""
    depth = (1 - 2 * image.amax(0, keepdim=True)).clamp(min=0)
    return torch.from_numpy(gaussian_filter(depth.numpy(), (0, 1.5, 1.5)))


def figure_12(side: int) -> Tensor:
    """Of each pair above registration each way and a dissolve, below control."""
    pairs = [(discs(side, 4, 0.3), discs(side, 3, 0.3)), (pebbles(side), pebbles(side, 1))]
    return under(*(film(a, b, method=name) for a, b in pairs for name in ("registration", "control")))


def figure_13(side: int) -> Tensor:
    """Above a large alpha, which nearly dissolves, below a small one, which moves."""
    a, b = pebbles(side), pebbles(side, 1)
    return under(*(film(a, b, alpha=alpha) for alpha in (1000.0, 15.0)))


def figure_14(side: int) -> Tensor:
    """Where it fails: structures of other sizes, shapes and places; A, halfway, made texture again, B."""
    pairs = [(coins(side), colored(picture(data.page(), side))), (weave(side), pebbles(side))]
    return under(*(beside(colored(a), half(a, b), half(a, b, retexture=True), colored(b)) for a, b in pairs))


def figure_flowing(side: int) -> Tensor:
    """A texture that flows to the right while it turns into another: every second of nine frames; it tiles."""
    a, b = (
        discs(side, 4, 0.3).expand(3, -1, -1),
        discs(side, 4, 0.42, 0.1) * torch.tensor([1.0, 0.7, 0.3]).view(3, 1, 1),
    )
    return beside(*flowing(a, b, 9, max(side / 32, 1.0))[::2])


def flowing(a: Tensor, b: Tensor, count: int, speed: float) -> list[Tensor]:
    """Frames from A to B, both tiling, that flow to the right by `speed` px each.

    Two terms: the frame before, carried along the flow, and the morph's frame, carried as far as the flow has come.
    """
    shape, pair = (a.shape[1], a.shape[2]), Pair(a, b, tile=True)
    made = synth.morph(a, b, count, method="control", tile=True).film
    pixels, motion = flow.warps.pixel_coordinates(shape), torch.tensor([speed, 0.0]).view(2, 1, 1)
    look = flow.lookup(motion.expand(2, *shape).contiguous(), wrap=True)
    settings = Settings(levels=(Level(1, 8, 2),), wrap=True)
    frames = [a]
    for number in range(1, count):
        place = pixels - number * motion
        still = morph_target(made, pair, number)
        target, weight = (flow.warp(image, place, "bilinear", wrap=True) for image in (still.target, still.weight))
        terms = flow_term(frames[-1], look, 1.0) + SoftPixels(target, weight)
        start = flow.warp(frames[-1], look.coordinates, wrap=True)
        source = Sources.of(pair).at(made.times[number])
        frames.append(optimize(source, shape, settings=settings, terms=terms, start=start).image)
    return frames


FIGURES: tuple[Callable[[int], Tensor], ...] = (
    figure_4, figure_5, figure_7, figure_8, figure_9, figure_12, figure_13, figure_14, figure_flowing,
)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=128, help="side of the exemplars and the frames")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="these figures alone: 4, 5, ... or flowing")
    parser.add_argument("--out", type=Path, default=Path("out/gallery_morph"), help="folder for the pictures")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    for figure in FIGURES:
        if arguments.only and figure.__name__.split("_")[1] not in arguments.only:
            continue
        path = arguments.out / f"{figure.__name__}.png"
        write_image(path, figure(arguments.side).clamp(0, 1), RGB, overwrite=True)
        print(f"{path}: {figure.__doc__}", flush=True)


if __name__ == "__main__":
    main()
