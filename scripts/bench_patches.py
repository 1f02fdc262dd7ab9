"""Textures in between by patches: what each part of the method is worth, and what a still costs.

    python scripts/bench_patches.py                              brick and gravel of scikit-image, and made stones
    python scripts/bench_patches.py pairs/ --write out/patches

Of each pair the texture halfway is made, by itself as published, with everything and without one part at a time:
relaxation, free centers, mean shift, warping, transport (the nearest neighborhood instead), scale, statistics,
rejection. Without `single partners` each window has three, and the best sixth of all neighborhoods is kept. Without `by
itself` it is led from A to B, as films are by default. `plain` is what mixes nearest neighborhoods without any of these
(Ruiters et al. 2010, figure 1c). Columns are those of `synth.metamorphosis.judging`, with A and B themselves as ends;
cpu, its seconds.
"""

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import tables
from bench_morph import add_common, made_pairs, pairs_in, written
from torch import Tensor

import synth
from synth.metamorphosis.judging import judge

TIMES = (0.0, 0.5, 1.0)
FIGURES = ("near", "progress", "sharpness", "ghost", "cpu")
WITHOUT: dict[str, dict[str, Any]] = {
    "all": {},
    "relaxation": {"relaxed": False},
    "free centers": {"free_centers": False},
    "mean shift": {"mean_shift": False},
    "warping": {"warped": False},
    "transport": {"transport": False},
    "scale": {"scaled": False},
    "statistics": {"statistics": False},
    "rejection": {"rejected": 0.0},
}
PLAIN = {name: value for options in WITHOUT.values() for name, value in options.items()}
ROWS: dict[str, dict[str, Any]] = WITHOUT | {
    "single partners": {"partners": 3, "rejected": 5 / 6},
    "by itself": {"independent": False},
    "plain": PLAIN,
}


def bench(pairs: dict[str, tuple[Tensor, Tensor]], arguments: argparse.Namespace) -> Iterator[tables.Row]:
    for name, (a, b) in pairs.items():
        for part in arguments.without:
            tables.progress(f"{name} without {part}")
            options = {"independent": True} | ROWS[part]
            cpu = time.process_time()
            made = synth.morph(a, b, TIMES, method="patches", preset=arguments.preset, seed=arguments.seed, **options)
            cpu = time.process_time() - cpu
            frames = [(frame.clamp(0, 1) * 255).round() / 255 for frame in made.frames]
            file = ""
            if arguments.write is not None:
                file = str(written(arguments.write / name / part.replace(" ", "_"), frames))
            yield tables.Row(name, part, file, judge(frames, made.times, a, b) | {"cpu": cpu})


def parsed(words: list[str] | None) -> argparse.Namespace:
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("pairs", nargs="*", type=Path, help="folders of pairs, or pairs")
    parser.add_argument("--without", nargs="+", choices=ROWS, default=[*ROWS], metavar="PART", help=", ".join(ROWS))
    add_common(parser)
    return parser.parse_args(words)


def run(arguments: argparse.Namespace) -> None:
    pairs = pairs_in(arguments.pairs) or made_pairs()
    tables.write_json(tables.print_table(bench(pairs, arguments), FIGURES, max(map(len, pairs))), arguments.json)


def main(words: list[str] | None = None) -> int:
    arguments = parsed(words)
    return tables.exit_code("bench_patches", lambda: run(arguments))


if __name__ == "__main__":
    sys.exit(main())
