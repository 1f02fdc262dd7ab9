"""Metamorphoses: how good each method's films are, in the project's own figures, and what they cost.

    python scripts/bench_morph.py                                    pairs that come with scikit-image or are made here
    python scripts/bench_morph.py pairs/ --frames 11 --write out/morph
    python scripts/bench_morph.py pairs/01_brick --methods blend control control+retexture

A pair is a folder with a.png and b.png; of any other folder, those in it are taken. A method is one of kwatra morph,
with +retexture if its frames are to be made texture again; pairs that it refuses are left out. The columns are those of
`synth.metamorphosis.judging`, and cpu, the cpu seconds of the whole film.
"""

import argparse
import json
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import tables
from exemplars import brick, gravel, pebbles
from torch import Tensor

import synth
from kwatra import InputError
from synth import read_image, write_image
from synth.metamorphosis.judging import judge
from synth.metamorphosis.methods import METHODS
from synth.sheets import contact_sheet

FIGURES = ("ends", "near", "progress", "sharpness", "ghost", "steps", "coherence", "overall", "cpu")
SIDE = 96


def pairs_in(folders: list[Path]) -> dict[str, tuple[Tensor, Tensor]]:
    """A and B by the name of their folder."""
    found = [
        pair for folder in folders for pair in ([folder] if (folder / "a.png").is_file() else sorted(folder.glob("*/")))
    ]
    found = [pair for pair in found if (pair / "a.png").is_file()]
    if folders and not found:
        raise InputError(f"{folders[0]} holds no a.png and b.png, nor folders that do; name a folder of pairs")
    return {pair.name: (read_image(pair / "a.png").pixels, read_image(pair / "b.png").pixels) for pair in found}


def made_pairs() -> dict[str, tuple[Tensor, Tensor]]:
    """Brick and gravel of scikit-image, and two fields of stones that differ."""
    return {
        "brick_gravel": (brick(SIDE), gravel(SIDE)),
        "pebbles": (pebbles(SIDE, 0), pebbles(SIDE, 1)),
    }


def method_of(text: str) -> str:
    name, plus, rest = text.partition("+")
    if name not in METHODS or (plus and rest != "retexture"):
        raise argparse.ArgumentTypeError(f"{text!r} is none of {', '.join(METHODS)}, alone or with +retexture")
    return text


def bench(pairs: dict[str, tuple[Tensor, Tensor]], arguments: argparse.Namespace) -> Iterator[tables.Row]:
    for name, (a, b) in pairs.items():
        for chosen in arguments.methods:
            tables.progress(f"{name} {chosen}")
            method, plus, _ = chosen.partition("+")
            cpu = time.process_time()
            try:
                made = synth.morph(
                    a,
                    b,
                    arguments.frames,
                    method=method,
                    retexture=bool(plus),
                    preset=arguments.preset,
                    seed=arguments.seed,
                )
            except InputError as refusal:
                print(f"{name} {chosen} is left out: {refusal}", file=sys.stderr)
                continue
            cpu = time.process_time() - cpu
            frames = [(frame.clamp(0, 1) * 255).round() / 255 for frame in made.frames]
            file = "" if arguments.write is None else str(written(arguments.write / name / chosen, frames))
            yield tables.Row(name, chosen, file, judge(frames, made.times, a, b) | {"cpu": cpu})


def written(folder: Path, frames: list[Tensor]) -> Path:
    """A folder of frames, and all of them in one picture beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    kind = tables.eight_bit(frames[0])
    for number, frame in enumerate(frames):
        write_image(folder / f"{number:04d}.png", frame, kind, overwrite=True)
    sheet = folder.with_name(f"{folder.name}.png")
    write_image(sheet, contact_sheet(frames), kind, overwrite=True)
    return sheet


def parsed(words: list[str] | None) -> argparse.Namespace:
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("pairs", nargs="*", type=Path, help="folders of pairs, or pairs")
    everything = [name + plus for name in METHODS for plus in ("", "+retexture")]
    parser.add_argument("--methods", nargs="+", type=method_of, default=everything, metavar="METHOD")
    parser.add_argument("--frames", type=int, default=11, help="how many, A and B included (11)")
    add_common(parser)
    return parser.parse_args(words)


def add_common(parser: argparse.ArgumentParser) -> None:
    """What all benchmarks of metamorphoses are told."""
    parser.add_argument("--preset", choices=("fast", "default", "best"), default="default")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--write", type=Path, metavar="DIR", help="write the frames, and a picture of all of them")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too")


def run(arguments: argparse.Namespace) -> None:
    pairs = pairs_in(arguments.pairs) or made_pairs()
    rows = tables.print_table(bench(pairs, arguments), FIGURES, max(map(len, pairs)))
    if arguments.json is not None:
        arguments.json.write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n", encoding="utf-8")


def main(words: list[str] | None = None) -> int:
    arguments = parsed(words)
    return tables.exit_code("bench_morph", lambda: run(arguments))


if __name__ == "__main__":
    sys.exit(main())
