"""What each part of the engine is worth: the default, changed in one way at a time, on the same exemplars.

    python scripts/ablation.py                              textures that come with scikit-image
    python scripts/ablation.py list.txt --images textures   the images named in a file, one a line
    python scripts/ablation.py --only "default" "textbook"

Prints the mean figures of each variant (those of kwatra.measure, as in bench.py: the last is the one to rank by,
lower is better, and is to be read with `copy`), and writes a contact sheet with one column per variant.
"""

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import bench
import tables
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra import THESIS, Exemplar, Feature, Level, Settings, gradient, match_histogram, optimize
from synth import read_image, write_image

Variant = Callable[[Tensor, tuple[int, int], int], Tensor]
"""From exemplar (C, H, W), output size and seed to an output."""

PLAIN = Settings()


def with_settings(settings: Settings = PLAIN, start: str = "aligned") -> Variant:
    return lambda z, size, seed: optimize(Exemplar.of(z), size, settings=settings, start=start, seed=seed).image


def histogram_matched(z: Tensor, size: tuple[int, int], seed: int) -> Tensor:
    return optimize(Exemplar.of(z), size, settings=PLAIN, seed=seed, between=match_histogram).image


def colors_carried(z: Tensor, size: tuple[int, int], seed: int) -> Tensor:
    """Levels start from the last one's image, enlarged, instead of from its source coordinates."""
    image = None
    for factor, widths in ((4, (8,)), (2, (16, 8)), (1, (16, 8))):
        there = (-(-size[0] // factor), -(-size[1] // factor))
        exemplar = Exemplar.of(z).coarser((factor, factor))
        settings = replace(PLAIN, levels=tuple(Level(1, width) for width in widths))
        start = "aligned" if image is None else F.interpolate(image[None], there, mode="bicubic", antialias=True)[0]
        image = optimize(exemplar, there, settings=settings, seed=seed, start=start).image
    assert image is not None
    return image


VARIANTS: dict[str, Variant] = {
    "default": with_settings(),
    "textbook": with_settings(replace(PLAIN, levels=THESIS), "windows"),
    "random windows": with_settings(start="windows"),
    "random blocks": with_settings(start="blocks"),
    "smaller blocks": with_settings(replace(PLAIN, block=0.25)),
    "one seam": with_settings(replace(PLAIN, seams=1)),
    "thesis levels": with_settings(replace(PLAIN, levels=THESIS)),
    "finest only": with_settings(replace(PLAIN, levels=(Level(1, 16), Level(1, 8)))),
    "colors carried": colors_carried,
    "not robust": with_settings(replace(PLAIN, r=2.0)),
    "gradients too": with_settings(replace(PLAIN, features=(Feature(gradient, 1.0),))),
    "histogram": histogram_matched,
}


def method(variant: Variant, size: tuple[int, int], seed: int) -> bench.Method:
    def make(exemplar: Path, output: Path) -> tuple[float, float]:
        picture = read_image(exemplar)
        cpu, wall = time.process_time(), time.perf_counter()
        image = variant(picture.pixels, size, seed)
        took = time.process_time() - cpu, time.perf_counter() - wall
        write_image(output, image.clamp(0, 1), picture.kind, overwrite=True)
        return took

    return make


def parsed(words: list[str] | None) -> argparse.Namespace:
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("exemplars", nargs="*", help="image files, names, or text files that list them")
    parser.add_argument("--images", type=Path, default=Path(), help="folder where names, with .png, are looked for")
    parser.add_argument("--size", type=tables.size, default=(256, 256), help="of the outputs, WIDTHxHEIGHT (256x256)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="+", choices=VARIANTS, metavar="VARIANT", help=f"of: {', '.join(VARIANTS)}")
    parser.add_argument("--out", type=Path, default=Path("out/ablation"), help="folder for the images (out/ablation)")
    return parser.parse_args(words)


def main(words: list[str] | None = None) -> int:
    arguments = parsed(words)
    chosen = {name: VARIANTS[name] for name in arguments.only or VARIANTS}
    return tables.exit_code("ablation", lambda: run(arguments, chosen))


def run(arguments: argparse.Namespace, chosen: dict[str, Variant]) -> None:
    given = tables.given_exemplars(arguments.exemplars, arguments.images)
    exemplars = given or tables.carried_exemplars()
    arguments.out.mkdir(parents=True, exist_ok=True)
    found = {name: method(variant, arguments.size, arguments.seed) for name, variant in chosen.items()}
    rows = list(bench.bench(exemplars, found, arguments.out))
    print(tables.line("", "variant", bench.FIGURES, 4))
    for row in tables.summaries(rows, bench.FIGURES):
        print(tables.row_line(replace(row, exemplar="" if row.exemplar == "mean" else "med."), bench.FIGURES, 4))
    print(f"images side by side: {bench.write_contact_sheet(arguments.out, exemplars, rows)}")


if __name__ == "__main__":
    torch.set_num_threads(1)  # cpu seconds then mean the same on every machine
    sys.exit(main())
