"""Three textures from three exemplars, as pictures in out/demo, with what they score.

brick and gravel come with scikit-image; the third, colored stones, is made here.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import torch
from skimage import data, transform
from torch import Tensor
from torch.nn import functional

from kwatra import measure
from synth import Kind, synthesize, write_image
from synth.commands.report import score_table

SIDE = 160


def brick(side: int) -> Tensor:
    """A corner of skimage's brick wall at half its size, (1, side, side)."""
    return _shrunk(data.brick(), side)


def gravel(side: int) -> Tensor:
    """A corner of skimage's gravel at half its size, (1, side, side)."""
    return _shrunk(data.gravel(), side)


def pebbles(side: int, seed: int = 0) -> Tensor:
    """Stones of four colors, each darker towards its lower right, (3, side, side): the cells of a jittered grid."""
    generator = np.random.default_rng(seed)
    spacing = 14
    grid = np.mgrid[-spacing : side + spacing : spacing, -spacing : side + spacing : spacing].reshape(2, -1).T
    centers = grid + generator.uniform(-6, 6, grid.shape)
    colors = np.array([[0.75, 0.45, 0.30], [0.55, 0.60, 0.62], [0.85, 0.78, 0.60], [0.35, 0.38, 0.45]])
    color = colors[generator.integers(0, len(colors), len(centers))]

    offset = np.mgrid[:side, :side] - centers[:, :, None, None]
    distance = np.sqrt((offset**2).sum(1))
    stone = distance.argmin(0)
    first, second = np.partition(distance, 1, axis=0)[:2]
    to_lower_right = np.take_along_axis(offset.sum(1), stone[None], 0)[0]
    joint = np.clip((second - first) / 3, 0.2, 1)
    grain = 1 + 0.06 * generator.standard_normal((side, side))
    image = color[stone] * ((1 - 0.015 * to_lower_right) * joint * grain)[..., None]
    return torch.from_numpy(image.clip(0, 1).transpose(2, 0, 1)).float()


def _shrunk(image: np.ndarray, side: int) -> Tensor:
    half = transform.rescale(image[: 2 * side, : 2 * side] / 255.0, 0.5, anti_aliasing=True)
    return torch.from_numpy(half).float()[None].clamp(0, 1)


def column(exemplar: Tensor, image: Tensor) -> Tensor:
    """The exemplar above the image, in color, with a white margin."""
    width = image.shape[2]
    above = functional.pad(exemplar, (0, width - exemplar.shape[2], 0, 8), value=1.0)
    return functional.pad(torch.cat([above, image], 1), (4, 4, 4, 4), value=1.0).expand(3, -1, -1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=SIDE, help="side of the exemplars; the outputs have twice that")
    parser.add_argument("--out", type=Path, default=Path("out/demo"), help="folder for the pictures")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    scores, columns = {}, []
    for make in (brick, gravel, pebbles):
        exemplar = make(arguments.side)
        began = time.perf_counter()
        image = synthesize(exemplar, (2 * arguments.side, 2 * arguments.side)).image
        kind = Kind("uint8", ("Y",) if len(exemplar) == 1 else ("R", "G", "B"))
        given, made = (arguments.out / f"{make.__name__}{ending}.png" for ending in ("", "_synth"))
        write_image(given, exemplar, kind, overwrite=True)
        write_image(made, image, kind, overwrite=True)
        scores[str(made)] = measure(image, exemplar)
        columns.append(column(exemplar, image))
        print(f"{given} -> {made}  ({time.perf_counter() - began:.1f} s)", flush=True)
    sheet = arguments.out / "textures.png"
    write_image(sheet, torch.cat(columns, 2), Kind("uint8", ("R", "G", "B")), overwrite=True)
    print(f"\nall side by side, exemplars above: {sheet}")
    print(f"\nscores (0 is perfect; sharpness: 1 is right)\n{score_table(scores)}")


if __name__ == "__main__":
    main()
