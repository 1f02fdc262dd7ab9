"""Holes filled, textures put where they are wanted, and what is kept: pictures of scikit-image, and some made in code.

python scripts/gallery_controls.py [--out out/controls.jpg] [--side 150]
"""

import argparse
from pathlib import Path

import numpy as np
import torch
from gallery_quilting import RGB, picture
from made import MADE
from scipy import ndimage
from skimage import data
from torch import Tensor

from kwatra import HardPixels
from synth import fill, synthesize, write_image
from synth.sheets import contact_sheet
from synth.texture import labels

DOTS = 400
"""A scribble is drawn of so many."""


def away(side: int) -> Tensor:
    """How far each pixel is from the middle, as a share of the side, (side, side)."""
    y, x = np.mgrid[:side, :side] - (side - 1) / 2
    return torch.from_numpy(np.hypot(y, x)) / side


def disc(side: int) -> Tensor:
    """A disc in the middle, a fifth of the side in radius, boolean (side, side)."""
    return away(side) < 1 / 5


def scribble(side: int) -> Tensor:
    """A wave from left to right, a fourteenth of the side wide, boolean (side, side)."""
    line = np.linspace(0.08, 0.92, DOTS)
    wave = 0.5 - 0.35 * np.sin(2.2 * np.pi * (line - 0.3))
    drawn = np.ones((side, side), bool)
    drawn[(wave * side).astype(int), (line * side).astype(int)] = False
    return torch.from_numpy(ndimage.distance_transform_edt(drawn) <= side / 28)


def filled(image: Tensor, hole: Tensor) -> list[Tensor]:
    """A picture (3, side, side) with its hole in white, and the same filled."""
    return [torch.where(hole, 1.0, image), fill(torch.where(hole, 0.5, image), hole).image]


def labeled(textures: list[Tensor], wanted: Tensor) -> list[Tensor]:
    """Two textures (3, side, side), where the second is wanted (side, side), and what comes of it."""
    wanted = wanted[None].float()
    made = synthesize(textures, guide=labels(textures, wanted)).image
    return [*textures, (0.35 + 0.43 * wanted).expand(3, -1, -1), made]


def continued(image: Tensor, side: int) -> list[Tensor]:
    """The middle of a picture (3, H, W) in white, three fifths of a side, and the same continued up to the side."""
    inner, around = side * 3 // 5, torch.ones(side, side, dtype=torch.bool)
    first = (side - inner) // 2
    middle = slice(first, first + inner)
    around[middle, middle] = False
    canvas = torch.ones(3, side, side)
    canvas[:, middle, middle] = image[:, :inner, :inner]
    return [canvas, fill(canvas, around).image]


def behind(image: Tensor, side: int) -> list[Tensor]:
    """A sign in white (3, side, side), and the texture of a picture (3, H, W) that goes on behind it."""
    inside = (away(side) < 0.3)[None]
    sign = torch.where(inside & (away(side) > 0.2), torch.tensor([0.85, 0.1, 0.1]).view(3, 1, 1), 1.0)
    made = synthesize(image, (side, side), terms=HardPixels(sign, inside)).image
    return [sign, torch.where(inside, sign, made)]


def main(words: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=150, help="of each picture, px (150)")
    parser.add_argument("--out", type=Path, default=Path("out/controls.jpg"), help="the file (out/controls.jpg)")
    arguments = parser.parse_args(words)
    side = arguments.side
    photos = data.coins(), data.gravel(), data.brick(), data.grass()
    coins, gravel, brick, grass = (picture(image, side) for image in photos)
    drawn = [MADE[name](side, side / 7, 0).image for name in ("stones", "coins")]
    wall = MADE["bricks"](side, side / 6, 0).image
    below = torch.cat([scribble(side), torch.ones(1, side)]).cumsum(0)[:side] > 0
    cells = [
        *filled(coins, disc(side)),
        *filled(gravel, scribble(side)),
        *labeled([brick, grass], disc(side)),
        *labeled(drawn, below),
        *continued(wall, side),
        *behind(drawn[0], side),
    ]
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    write_image(arguments.out, contact_sheet(cells, 4).clamp(0, 1), RGB, overwrite=True)
    print(f"{arguments.out}: {__doc__.splitlines()[0]}")


if __name__ == "__main__":
    main()
