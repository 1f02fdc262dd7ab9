"""What the benchmarks share: the exemplars they are given, and tables that are printed row by row."""

import json
import math
import statistics
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import torch
from skimage import data
from torch import Tensor

from kwatra import Exemplar, InputError
from synth import Kind, read_image
from synth.texture.illumination import under_even_light


@dataclass(frozen=True)
class Row:
    """What one method did with one exemplar: figures by name, NaN where there is none, and the file it made."""

    exemplar: str
    method: str
    file: str
    figures: dict[str, float]


def exit_code(name: str, work: Callable[[], None]) -> int:
    """Do a script's work; bad input is one sentence and 2, Ctrl-C 130."""
    try:
        work()
    except (InputError, OSError) as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


def write_json(rows: Iterable[Row], path: Path | None) -> None:
    """Write the rows to a file, if one was named; what there is no figure for is null."""
    if path is None:
        return
    figures = [
        {**asdict(row), "figures": {name: None if math.isnan(v) else v for name, v in row.figures.items()}}
        for row in rows
    ]
    path.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


def numbers(text: str) -> list[int]:
    found = [int(part) for part in text.split(",")]
    if min(found) < 1:
        raise ValueError(text)
    return found


def several(text: str) -> int:
    """A number of frames: at least two, so that there is a pair."""
    if int(text) < 2:
        raise ValueError(text)
    return int(text)


def carried_exemplars() -> dict[str, Tensor]:
    """Textures (C, 128, 128) from the images that come with scikit-image, none of them downloaded.

    Of the page, part of which lies in shadow, it is the text without that: else figures tell who keeps the shadow.
    """
    crops = {
        "brick": halved(data.brick())[:128, :128],
        "grass": halved(data.grass())[:128, :128],
        "gravel": halved(data.gravel())[:128, :128],
        "text": under_light(data.page())[60:188, 110:238],
        "tissue": data.immunohistochemistry()[32:160, :128],
        "wood": data.coffee()[:128, 472:600],
    }
    pixels = {name: np.atleast_3d(crop).transpose(2, 0, 1) for name, crop in crops.items()}
    return {name: torch.from_numpy(crop.astype(np.float32)) / 255 for name, crop in pixels.items()}


def under_light(image: np.ndarray) -> np.ndarray:
    """A gray image (H, W) in 0..255 under even light."""
    lit = Exemplar.of(torch.from_numpy(image.astype(np.float32))[None] / 255)
    return under_even_light(lit, 0.0).pictures()[0][0].numpy() * 255


def halved(image: np.ndarray) -> np.ndarray:
    height, width = image.shape
    return image.reshape(height // 2, 2, width // 2, 2).mean((1, 3))


def given_exemplars(names: list[str], folder: Path) -> dict[str, Tensor]:
    """Images by name, from files, names in `folder`, and text files that list such, one a line."""
    listed = [name for given in names for name in expanded(given)]
    paths = [Path(name) if Path(name).is_file() else folder / f"{name}.png" for name in listed]
    return {path.stem: read_image(path).pixels for path in paths}


def expanded(name: str) -> list[str]:
    if not name.endswith(".txt"):
        return [name]
    try:
        return Path(name).read_text(encoding="utf-8").split()
    except OSError as error:
        raise InputError(f"{name} cannot be read as a list of names: {error.strerror}") from None


def eight_bit(image: Tensor) -> Kind:
    """The kind of PNG file for an image (C, H, W) of up to four channels."""
    names = {1: "Y", 2: "YA", 3: "RGB", 4: "RGBA"}[image.shape[0]]
    return Kind("uint8", tuple(names))


def progress(text: str) -> None:
    """One line on a terminal, overwritten by the next; nothing elsewhere."""
    if sys.stderr.isatty():
        print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)


def line(exemplar: str, method: str, cells: Iterable[str], width: int) -> str:
    return "  ".join([exemplar.ljust(width), method.ljust(18), *(cell.rjust(11) for cell in cells)])


def row_line(row: Row, names: Sequence[str], width: int) -> str:
    return line(row.exemplar, row.method, (number(row.figures[name]) for name in names), width)


def number(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.3f}"


def print_table(rows: Iterable[Row], names: Sequence[str], width: int) -> list[Row]:
    """Print rows as they come, then the mean and the median of each method; returns the rows. names: the figures."""
    print(line("exemplar", "method", names, width), flush=True)
    kept: list[Row] = []
    for row in rows:
        progress("")
        print(row_line(row, names, width), flush=True)
        kept.append(row)
    for summary in summaries(kept, names):
        print(row_line(summary, names, width))
    return kept


def summaries(rows: list[Row], names: Sequence[str]) -> Iterator[Row]:
    """Means, then medians, of each method's figures, of those that there are."""
    for name, average in (("mean", statistics.mean), ("median", statistics.median)):
        for method in dict.fromkeys(row.method for row in rows):
            columns = {figure: [row.figures[figure] for row in rows if row.method == method] for figure in names}
            known = {figure: [v for v in values if not math.isnan(v)] for figure, values in columns.items()}
            yield Row(name, method, "", {figure: average(v) if v else math.nan for figure, v in known.items()})


def size(text: str) -> tuple[int, int]:
    """(height, width) from WIDTHxHEIGHT."""
    width, height = (int(side) for side in text.lower().split("x"))
    return height, width


def number_list(text: str) -> list[int]:
    """Numbers, 0 or more, from a list with commas."""
    found = [int(part) for part in text.split(",")]
    if min(found) < 0:
        raise ValueError(text)
    return found
