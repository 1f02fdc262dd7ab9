"""What is asked of stills is followed, and how many elements that cuts: labels, tones and kept pieces.

    python scripts/bench_guides.py                              all, of made textures with elements of 24 and 40 pixels
    python scripts/bench_guides.py --asked labels --sizes 32 --seeds 3

Rows are textures, made in code, of which each pixel's element is known, and what is asked of the output:

    labels       two textures, each where blobs of about a quarter of the output want it
    tones        light and dark in a wave from left to right
    kept         a piece of the exemplar in the middle, which stays as it is

The columns:

    cpu          seconds of this process
    cut          share of the elements that are cut, as bench_elements.py has it; of labels each texture is looked at as
                 if the other were ground
    followed     of labels the share of pixels that are of the texture that is wanted there; of tones what slope the
                 shown ones have over those that are wanted, between the darkest and the lightest tenth
    border       of kept pieces how much colors step across its border, as a multiple of what they do elsewhere
"""

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import torch
from bench_elements import cut_elements, places_of
from made import MADE, Made
from scipy import ndimage
from tables import Row, exit_code, print_table, progress, write_json
from torch import Tensor

from kwatra import HardPixels
from synth import synthesize
from synth.texture import labels, tones

FIGURES = ("cpu", "cut", "followed", "border")
TEXTURES = "stones", "coins", "tiles", "mosaic", "letters"
SIDE, SMALLER = 256, 0.4
"""Of exemplars and outputs, px; of a kept piece, as a share."""

Figures = dict[str, float]


def blobs(side: int, seed: int) -> np.ndarray:
    """Zeros and ones (side, side) in blobs."""
    noise = np.random.default_rng(seed).standard_normal((2, side, side))
    one, other = ndimage.gaussian_filter(noise, (0, side / 8, side / 8), mode="wrap")
    return (one > other).astype(np.uint8)


def labeled(one: Made, other: Made, side: int, seed: int, preset: str) -> Figures:
    """Of two textures by labels."""
    wanted, images = blobs(side, seed), [one.image, other.image]
    guide = labels(images, torch.from_numpy(wanted)[None])
    made = synthesize(images, guide=guide, seed=seed, preset=preset)
    shown, places = made.source[0], made.take([places_of(image) for image in images])
    cut = elements = 0.0
    for number, texture in enumerate((one, other)):
        own = texture.numbers.numpy()
        found = cut_elements(own, np.where(shown == number, places, np.flatnonzero(own == 0)[0]))
        cut, elements = cut + found["cut"] * found["elements"], elements + found["elements"]
    return {"cut": cut / elements, "followed": float((shown == wanted).mean())}


def toned(texture: Made, side: int, seed: int, preset: str) -> Figures:
    """Of a texture by a wave of tones."""
    wave = 0.5 + 0.5 * torch.sin(torch.linspace(0, 4.5, side))
    drawing = wave.expand(len(texture.image), side, side)
    made = synthesize(texture.image, guide=tones(texture.image, drawing), guide_weight=0.3, seed=seed, preset=preset)
    around = side / 20
    low, high = np.quantile(ndimage.gaussian_filter(texture.image.mean(0).numpy(), around), (0.1, 0.9))
    shown = ndimage.gaussian_filter1d(made.image.mean((0, 1)).double().numpy(), around)
    slope = np.polyfit(wave.numpy(), shown, 1)[0] / (high - low)
    return {"cut": _cut(texture, made.take(places_of(texture.image))), "followed": float(slope)}


def kept(texture: Made, side: int, seed: int, preset: str) -> Figures:
    """Of a texture of which a piece of the exemplar is kept."""
    image, size = texture.image, round(SMALLER * side)
    low, high = image.aminmax()
    first = (side - size) // 2
    inside, piece = torch.zeros(side, side, dtype=torch.bool), torch.zeros(len(image), side, side)
    inside[first : first + size, first : first + size] = True
    piece[:, inside] = ((image - low) / (high - low))[:, :size, :size].flatten(1)
    terms = HardPixels(piece, inside.expand(len(image), -1, -1))
    made = synthesize(image, (side, side), terms=terms, seed=seed, preset=preset)
    places = made.take(places_of(image))
    places[inside.numpy()] = places_of(image)[:size, :size].ravel()
    return {"cut": _cut(texture, places), "border": border(made.result.image, inside)}


def border(image: Tensor, inside: Tensor) -> float:
    """How much an image (C, H, W) steps across the border of a part (H, W), by how much it does outside of that."""
    across, elsewhere = list[Tensor](), list[Tensor]()
    for axis, size in enumerate(inside.shape):
        step = image.diff(dim=axis + 1).abs().sum(0)
        one, other = inside.narrow(axis, 0, size - 1), inside.narrow(axis, 1, size - 1)
        across.append(step[one != other])
        elsewhere.append(step[~one & ~other])
    return float(torch.cat(across).mean() / torch.cat(elsewhere).mean())


def _cut(texture: Made, places: np.ndarray) -> float:
    return cut_elements(texture.numbers.numpy(), places)["cut"]


ASKED: dict[str, Callable[[Made, int, int, str], Figures]] = {"tones": toned, "kept": kept}


def bench(arguments: argparse.Namespace) -> Iterator[Row]:
    """A row for each texture, size and seed, and what is asked."""
    for element in arguments.sizes:
        for seed in range(arguments.seeds):
            made = {name: MADE[name](arguments.side, element, seed) for name in arguments.textures}
            for number, (name, texture) in enumerate(made.items()):
                progress(f"{name} {element}, seed {seed}")
                beside = arguments.textures[(number + 1) % len(made)]
                for asked in arguments.asked:
                    cpu = time.process_time()
                    if asked == "labels":
                        found = labeled(texture, made[beside], arguments.side, seed, arguments.preset)
                    else:
                        found = ASKED[asked](texture, arguments.side, seed, arguments.preset)
                    figures = {"cpu": time.process_time() - cpu, **found}
                    row = f"{name} and {beside} {element}" if asked == "labels" else f"{name} {element}"
                    yield Row(row, asked, "", {name: figures.get(name, float("nan")) for name in FIGURES})


def parsed(words: list[str] | None) -> argparse.Namespace:
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--textures", nargs="+", choices=TEXTURES, default=list(TEXTURES), metavar="TEXTURE")
    parser.add_argument("--asked", nargs="+", choices=("labels", *ASKED), default=["labels", *ASKED])
    parser.add_argument("--sizes", nargs="+", type=int, default=[24, 40], help="of elements, px (24 40)")
    parser.add_argument("--side", type=int, default=SIDE, help=f"of exemplars and outputs, px ({SIDE})")
    parser.add_argument("--seeds", type=int, default=2, help="how many; each makes other textures (2)")
    parser.add_argument("--preset", choices=("fast", "default", "best"), default="default")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too")
    return parser.parse_args(words)


def run(arguments: argparse.Namespace) -> None:
    longest = max(len(name) for name in arguments.textures)
    write_json(print_table(bench(arguments), FIGURES, 2 * longest + len(" and  40")), arguments.json)


def main(words: list[str] | None = None) -> int:
    arguments = parsed(words)
    return exit_code("bench_guides", lambda: run(arguments))


if __name__ == "__main__":
    torch.set_num_threads(1)  # cpu seconds then mean the same on every machine
    sys.exit(main())
