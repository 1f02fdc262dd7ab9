"""What a run can tell about itself: its energy as a table (.csv) or a picture (.png), and scores as text."""

import csv
import io
import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from synth import io as files

if TYPE_CHECKING:
    from synth.io import Writer

ENERGY_SUFFIXES = (".csv", ".png")

Row = Mapping[str, object]

_WIDTH, _HEIGHT, _MARGIN = 960, 480, 60
_CURVES = ("#1f6fb4", "#d2691e", "#2f8f4e", "#8a4fa3", "#a33d3d", "#5f6b73")
_AXES, _LEVELS = "#444444", "#cccccc"
_NO_ENERGIES = {"label", "stretch", "level", "factor", "width", "iteration", "route", "changed", "residual"}
_COLUMNS = ["level", "factor", "width", "iteration", "route", "changed", "texture", "total"]


def energy_writer(path: Path, energies: Sequence[Row]) -> "Writer":
    """What writes the energies, one row per iteration, as a table or a picture by the ending of `path`.

    There are none where the exemplar goes on by itself: the table then has its heads alone.
    """
    data = _table(energies) if path.suffix.lower() == ".csv" else _plot(energies)
    return files.bytes_writer(data)


def _table(energies: Sequence[Row]) -> bytes:
    columns = list(dict.fromkeys(key for row in energies for key in row)) or _COLUMNS
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, columns, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(energies)
    return text.getvalue().encode()


def _plot(energies: Sequence[Row]) -> bytes:
    """Every energy over the iterations, level by level, on a logarithmic axis."""
    from PIL import Image, ImageDraw, ImageFont

    image = Image.new("RGB", (_WIDTH, _HEIGHT), "white")
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(14)
    curves = _curves(energies)
    shown = [value for curve in curves.values() for value in curve if value > 0]
    low, high = _decades(shown)

    def place(index: float, value: float) -> tuple[float, float]:
        across = (_WIDTH - 2 * _MARGIN) * index / max(len(energies) - 1, 1)
        up = (math.log10(value) - low) / (high - low)
        return _MARGIN + across, _HEIGHT - _MARGIN - (_HEIGHT - 2 * _MARGIN) * up

    for power in range(low, high + 1):
        y = place(0, 10.0**power)[1]
        draw.line([(_MARGIN, y), (_WIDTH - _MARGIN, y)], _LEVELS)
        draw.text((_MARGIN - 8, y), f"1e{power}", _AXES, font, "rm")
    for level in _levels(energies):
        row, x = energies[level[0]], place(level[0], 10.0**low)[0]
        draw.line([(x, _MARGIN), (x, _HEIGHT - _MARGIN)], _LEVELS)
        window = f", width {row['width']}" if "width" in row else ""
        draw.text((x + 4, _MARGIN), f"scale 1/{row['factor']}{window}", _AXES, font, "ld")
    for number, (name, curve) in enumerate(curves.items()):
        color = _CURVES[number % len(_CURVES)]
        for level in _levels(energies):
            points = [place(index, curve[index]) for index in level if curve[index] > 0]
            draw.line(points, color, 2)
            for point in points:
                draw.circle(point, 3, color)
        draw.text((_MARGIN + 130 * number, 20), name, color, font, "lm")
    draw.text((_WIDTH / 2, _HEIGHT - 20), "iteration", _AXES, font, "mm")
    stream = io.BytesIO()
    image.save(stream, "png")
    return stream.getvalue()


def _curves(energies: Sequence[Row]) -> dict[str, list[float]]:
    """The columns that are energies: numbers that say neither where in the run a row is nor how it was solved."""
    names = dict.fromkeys(key for row in energies for key in row)
    rest = [name for name in names if name not in _NO_ENERGIES]
    if len(rest) == 2:  # the texture alone is the total
        rest = rest[:1]
    return {name: [_number(row.get(name)) for row in energies] for name in rest}


def _levels(energies: Sequence[Row]) -> list[range]:
    """The rows of each level of each part: energies of different levels are no one curve."""
    parts = [tuple(row.get(name) for name in ("label", "stretch", "level")) for row in energies]
    starts = [i for i, part in enumerate(parts) if i == 0 or part != parts[i - 1]]
    return [range(start, end) for start, end in pairwise([*starts, len(energies)])]


def _number(value: object) -> float:
    return float(value) if isinstance(value, (int, float)) and math.isfinite(value) else 0.0


def _decades(values: Sequence[float]) -> tuple[int, int]:
    """Powers of ten that hold all values (all above 0)."""
    if not values:
        return 0, 1
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    return low, max(high, low + 1)


def score_table(scores: Mapping[str, Mapping[str, float]]) -> str:
    """Scores by output file as lines of text, one file per line, one measure per column."""
    names = list(dict.fromkeys(name for row in scores.values() for name in row))
    first = max([len("output"), *map(len, scores)])
    lines = ["  ".join(["output".ljust(first), *(name.rjust(max(len(name), 7)) for name in names)])]
    for file, row in scores.items():
        cells = (f"{row[name]:.4f}".rjust(max(len(name), 7)) for name in names)
        lines.append("  ".join([file.ljust(first), *cells]))
    return "\n".join(lines)
