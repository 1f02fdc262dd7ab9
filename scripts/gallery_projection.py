"""Thesis figure 27: texture optimization as a projection onto the texture.

A checkerboard is deformed by a twirl and given to the optimization as its start. EM brings it back to the nearest
image made of checkerboard windows: at the finest resolution alone it can mend a weak twirl; with three resolutions,
which see larger neighborhoods, also a stronger one. Rows of the picture: deformed, one resolution, three.

    python scripts/gallery_projection.py [--out out/projection.png] [--size 128]
"""

import argparse
from pathlib import Path

import numpy as np
import torch
from PIL import Image
from skimage.transform import swirl

from kwatra import Exemplar, Level, Settings, optimize

ONE = (Level(1, 32, 12), Level(1, 16, 6), Level(1, 8, 4))
THREE = (Level(4, 8, 12), Level(2, 16, 12), Level(2, 8, 6), Level(1, 16, 6), Level(1, 8, 4))
TWIRLS = (1.0, 2.5, 5.0)


def checkerboard(size: int, square: int) -> torch.Tensor:
    """A checkerboard (1, size, size) of 0.1 and 0.9 with squares of `square` pixels."""
    y, x = np.mgrid[:size, :size] // square
    return torch.from_numpy(((y + x) % 2 * 0.8 + 0.1).astype(np.float32))[None]


def twirled(image: torch.Tensor, strength: float) -> torch.Tensor:
    """The image turned about its middle, less so farther out; strength in radians."""
    size = image.shape[-1]
    bent = swirl(image[0].numpy(), strength=strength, radius=0.55 * size, mode="reflect", order=1)
    return torch.from_numpy(bent.astype(np.float32))[None]


def wrong_pixels(image: torch.Tensor, exemplar: torch.Tensor) -> float:
    """Share of pixels on the wrong side of gray, against the checkerboard it should have become."""
    return float(((image > 0.5) != (exemplar > 0.5)).float().mean())


def repaired(start: torch.Tensor, exemplar: torch.Tensor, levels: tuple[Level, ...]) -> torch.Tensor:
    """The start brought to the nearest image made of the exemplar's windows."""
    settings = Settings(levels=levels)
    return optimize(Exemplar.of(exemplar), tuple(start.shape[1:]), settings=settings, start=start).image


def main(arguments: list[str] | None = None) -> list[dict[str, float]]:
    """Draw the figure; returns the share of wrong pixels per twirl."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/projection.png"))
    parser.add_argument("--size", type=int, default=128)
    options = parser.parse_args(arguments)
    exemplar = checkerboard(options.size, options.size // 8)
    columns, rows = [], []
    for strength in TWIRLS:
        start = twirled(exemplar, strength)
        one, three = repaired(start, exemplar, ONE), repaired(start, exemplar, THREE)
        columns.append(torch.cat([torch.nn.functional.pad(i[0], (4, 4, 4, 4), value=1.0) for i in (start, one, three)]))
        row = {"twirl": strength}
        row |= {k: wrong_pixels(i, exemplar) for k, i in (("start", start), ("one", one), ("three", three))}
        rows.append(row)
        print("  ".join(f"{k} {v:.3f}" for k, v in row.items()))
    options.out.parent.mkdir(parents=True, exist_ok=True)
    picture = torch.cat(columns, 1).clamp(0, 1).mul(255).round().byte().numpy()
    Image.fromarray(picture).save(options.out)
    print(f"rows: deformed, one resolution, three; written to {options.out}")
    return rows


if __name__ == "__main__":
    main()
