"""Three textures from three exemplars, as pictures in out/demo, with what they score.

A brick wall, its perspective taken out, and gravel come with scikit-image; the third, colored stones, is made here.
"""

import argparse
import time
from pathlib import Path

import torch
from exemplars import gravel, pebbles, wall
from torch import Tensor
from torch.nn import functional

from kwatra import measure
from synth import Kind, synthesize, write_image
from synth.commands.report import score_table

SIDE = 160


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
    for make in (wall, gravel, pebbles):
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
