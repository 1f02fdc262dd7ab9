"""How many elements a rearrangement cuts, on made textures of which each pixel's element is known.

    python scripts/bench_elements.py                                        all textures, methods, flows and sizes
    python scripts/bench_elements.py stones letters --sizes 32 --methods default quilting --flows
    python scripts/bench_elements.py coins --methods --flows vortices --at 0,60,150 --json figures.json

Rows are texture and element size. The methods are the presets of synthesis; quilting; copies and blocks, two controls:
whole pieces of the exemplar, and random blocks of 32 pixels; and flowing frames (flow.animate, 2 px per frame), each
named by its field and number. "exact" beside it is what a control cuts that moves each element as a whole and keeps it
upright: where elements come to overlap one hides a part of the other; it is left out of what touches. Colors are never
looked at: the element of an output pixel is that of the exemplar pixel which it was copied from.

An output element is what is seen as one thing: pieces, each a region of touching pixels of one element of the exemplar,
that are grown together. Two pieces are if the boundary at which they touch, with no ground between them, is longer than
a third of the smaller one's width (the root of its area); what touches in a few pixels is seen as two. Where elements
touch in the exemplar (patches, confetti) only what is torn counts of a boundary: a seam at which both go on in the
exemplar, by more than two pixels. Its element is that of most of its pixels. It is cut if one of these holds:

    mixed        more than a tenth of the region is of other elements: a part of one grown onto another
    part         away from the output's border less than four fifths of its element's area is shown (a pixel counts as
                 shown where it or one of its eight neighbors is): cut off along a seam that leads through it
    swollen      more than a fifth of the element's area is shown more than once: grown onto itself

Bricks are of one shape and nearly of one color: halves of two that make up a whole count as mixed (.40 of stills by
quilting), though little is seen of that. What tears a wall apart, as flows do, adds to it.

An element that the exemplar's own border cuts is taken to have at least the median area of those that are whole: what
there is of a large part is shown as a whole, a small one never. A region counts as one element, or as many as go by
their median area into its own: many grown together are many that are cut. Regions below a twentieth of that area are
crumbs, and no elements. Two whole elements grown together are mixed: the boundary that was there is lost. What confetti
hides of confetti is no part: there only mixed and torn say something. The columns:

    cut          share of the elements that are cut
    mixed, part, swollen   shares that are so; an element may be several
    torn         share of the boundaries between elements, and with the ground, that is torn
    elements     how many there are, crumbs left out
    crumbs       how many crumbs there are
"""

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path

import numpy as np
from made import GROUND, MADE, Made
from moved import exactly_moved
from scipy import ndimage, sparse
from tables import Row, exit_code, number_list, print_table, progress, size
from torch import Tensor

import flow
from synth import synthesize
from synth.quilting import QuiltSettings, quilt
from synth.texture.work import PRESETS

GROWN, MIXED, SHOWN, SWOLLEN, CRUMB, BEYOND = 1 / 3, 0.1, 0.8, 0.2, 0.05, 2
FIGURES = ("cut", "mixed", "part", "swollen", "torn", "elements", "crumbs")
FIELDS = {"rotation": flow.rotation, "vortices": flow.vortices}
BLOCK = 32
TOUCHING = np.ones((3, 3))

Shape = tuple[int, int]
Method = Callable[[Tensor, Shape, int], np.ndarray]
"""Makes an output of a shape from an exemplar (C, H, W) and a seed; for each pixel the flat number of the exemplar's
pixel that it was copied from, (H, W)."""


def cut_elements(numbers: np.ndarray, source: np.ndarray, touching: bool = False) -> dict[str, float]:
    """The figures of an output (H, W) of flat places `source` in an exemplar with these element `numbers` (H, W).

    touching: whether elements touch there.
    """
    shown = numbers.flat[source]
    beside = _beside(shown.shape)
    torn = _torn(numbers, source, beside)
    regions = grown_together(shown, beside[:, torn] if touching else beside)
    count = int(regions.max())
    areas = np.bincount(numbers.ravel())
    median = np.median(areas[_whole(numbers)])
    areas[_at_border(numbers)] = np.maximum(areas[_at_border(numbers)], median)
    faults, weights = [], []
    for number, box in enumerate(ndimage.find_objects(regions), 1):
        inside = regions[box] == number
        if inside.sum() >= CRUMB * median:
            touches = any(s.start == 0 or s.stop == side for s, side in zip(box, shown.shape, strict=True))
            weights.append(max(inside.sum() / median, 1.0))
            faults.append(_faults(shown[box][inside], source[box][inside], numbers, areas, touches))
    table = np.array(faults, dtype=float).reshape(-1, 3)
    table = np.column_stack([table.any(1), table])
    shares = np.average(table, 0, weights) if len(table) else np.full(4, np.nan)
    bounds = max(np.count_nonzero(torn | (np.diff(shown.flat[beside], axis=0)[0] != 0)), 1)
    counts = float(torn.sum() / bounds), float(sum(weights)), float(count - len(table))
    return dict(zip(FIGURES, (*shares.tolist(), *counts), strict=True))


def _torn(numbers: np.ndarray, source: np.ndarray, beside: np.ndarray) -> np.ndarray:
    """Whether between pixels beside each other (2, N) both their elements, or the ground of one, end in a seam."""
    window = 2 * BEYOND + 1
    inner = ndimage.minimum_filter(numbers, window) == ndimage.maximum_filter(numbers, window)
    row, column = np.divmod(source.flat[beside], numbers.shape[1])
    apart = np.abs(np.diff(row, axis=0)) + np.abs(np.diff(column, axis=0)) > BEYOND
    grounds = (numbers[row, column] == GROUND).all(0)
    return apart[0] & inner[row, column].all(0) & ~grounds


def grown_together(shown: np.ndarray, beside: np.ndarray) -> np.ndarray:
    """The number (H, W) of the output element that each pixel is part of, from 1; 0 for the ground.

    beside: pixels (2, N) whose pieces are one if they touch.
    """
    pixels = np.arange(shown.size).reshape(shown.shape)
    corner = np.concatenate([_pairs(pixels, 1, 1), _pairs(pixels[:, ::-1], 1, 1)], 1)
    near = np.concatenate([_beside(shown.shape), corner], 1)
    pieces = _connected(near[:, shown.flat[near[0]] == shown.flat[near[1]]], shown.size)
    areas = np.bincount(pieces)
    touching = beside[:, (shown.flat[beside] > 0).all(0)]
    between = np.sort(pieces[touching], 0)
    between, length = np.unique(between[:, between[0] != between[1]], axis=1, return_counts=True)
    joined = between[:, length > GROWN * np.sqrt(areas[between].min(0))]
    regions = _connected(joined, len(areas))[pieces].reshape(shown.shape)
    numbered = np.unique(np.where(shown > 0, regions + 1, 0), return_inverse=True)[1].reshape(shown.shape)
    return numbered if (shown == 0).any() else numbered + 1


def _beside(shape: Shape) -> np.ndarray:
    """Each two pixels, by number, of which one is right of the other or below (2, N)."""
    pixels = np.arange(shape[0] * shape[1]).reshape(shape)
    return np.concatenate([_pairs(pixels, 0, 1), _pairs(pixels, 1, 0)], 1)


def _pairs(pixels: np.ndarray, down: int, right: int) -> np.ndarray:
    """Each pixel and the one so far from it, (2, N)."""
    height, width = pixels.shape
    return np.stack([pixels[: height - down, : width - right].ravel(), pixels[down:, right:].ravel()])


def _connected(pairs: np.ndarray, count: int) -> np.ndarray:
    """The component (count,) of each of `count` nodes that `pairs` (2, N) of them connect."""
    graph = sparse.coo_matrix((np.ones(pairs.shape[1]), tuple(pairs)), shape=(count, count))
    return sparse.csgraph.connected_components(graph, directed=False)[1]


def _faults(
    elements: np.ndarray, places: np.ndarray, numbers: np.ndarray, areas: np.ndarray, at_border: bool
) -> tuple[bool, bool, bool]:
    """Whether a region is mixed, a part, or swollen."""
    element = np.bincount(elements).argmax()
    own = places[elements == element]
    mixed = len(own) < (1 - MIXED) * len(elements)
    rows, columns = (slice(s.min(), s.max() + 1) for s in np.nonzero(numbers == element))
    seen = np.zeros(numbers.shape, dtype=bool)
    seen.flat[own] = True
    there = numbers[rows, columns] == element
    near = ndimage.binary_dilation(seen[rows, columns], TOUCHING, mask=there)
    part = not at_border and near.sum() < SHOWN * areas[element]
    return mixed, part, len(own) - near.sum() > SWOLLEN * areas[element]


def _at_border(numbers: np.ndarray) -> np.ndarray:
    """The elements that the border cuts, the ground not among them."""
    border = np.concatenate([numbers[0], numbers[-1], numbers[:, 0], numbers[:, -1]])
    return np.setdiff1d(border, 0)


def _whole(numbers: np.ndarray) -> np.ndarray:
    whole = np.setdiff1d(numbers, [0, *_at_border(numbers)])
    return whole if len(whole) else np.setdiff1d(numbers, 0)


def places_of(exemplar: Tensor) -> np.ndarray:
    """The flat number (H, W) of each pixel of an exemplar (C, H, W)."""
    return np.arange(exemplar[0].numel()).reshape(exemplar.shape[1:])


def synthesized(preset: str) -> Method:
    def make(exemplar: Tensor, shape: Shape, seed: int) -> np.ndarray:
        return synthesize(exemplar, shape, preset=preset, seed=seed).take(places_of(exemplar))

    return make


def quilted(exemplar: Tensor, shape: Shape, seed: int) -> np.ndarray:
    offset = quilt(exemplar, shape, QuiltSettings(seed=seed)).offset.numpy()
    row, column = np.indices(shape) + offset
    return places_of(exemplar)[row, column]


def copied(exemplar: Tensor, shape: Shape, seed: int) -> np.ndarray:
    """A piece of the exemplar, as large as fits: what cuts nothing."""
    rng = np.random.default_rng(seed)
    places = places_of(exemplar)
    sides = [min(there, 3 * here // 4) for there, here in zip(shape, places.shape, strict=True)]
    top, left = (int(rng.integers(here - side + 1)) for here, side in zip(places.shape, sides, strict=True))
    return places[top : top + sides[0], left : left + sides[1]]


def in_blocks(exemplar: Tensor, shape: Shape, seed: int) -> np.ndarray:
    """Blocks from anywhere side by side: what cuts all that is not smaller than they."""
    rng = np.random.default_rng(seed)
    places = places_of(exemplar)
    made = np.zeros(shape, dtype=np.int64)
    for top in range(0, shape[0], BLOCK):
        for left in range(0, shape[1], BLOCK):
            here = made[top : top + BLOCK, left : left + BLOCK]
            row, column = (int(rng.integers(a - b + 1)) for a, b in zip(places.shape, here.shape, strict=True))
            here[:] = places[row : row + here.shape[0], column : column + here.shape[1]]
    return made


METHODS: dict[str, Method] = {
    **{preset: synthesized(preset) for preset in PRESETS},
    "quilting": quilted,
    "copies": copied,
    "blocks": in_blocks,
}


def flowing(field: flow.Field, exemplar: Tensor, shape: Shape, seed: int, at: list[int]) -> Iterator[np.ndarray]:
    """The source of each frame whose number is in `at`, ascending."""
    places = places_of(exemplar)
    for number, frame in enumerate(flow.animate(exemplar, field, shape, frames=max(at) + 1, seed=seed)):
        if number in at:
            _, row, column = frame.source.numpy()
            yield places[row, column]


def figures(
    arguments: argparse.Namespace, texture: str, element: int, seed: int
) -> Iterator[tuple[str, dict[str, float]]]:
    """Every method's name, and what it cuts of a texture."""
    made = MADE[texture](arguments.side, element, seed)
    for name in arguments.methods:
        yield name, _cut(made, METHODS[name](made.image, arguments.size, seed))
    at = sorted(set(arguments.at))
    wide = MADE[texture](2 * max(arguments.size), element, seed) if arguments.flows else made
    for name in arguments.flows:
        field = FIELDS[name]()
        for number, frame in zip(at, flowing(field, made.image, arguments.size, seed, at), strict=True):
            yield f"{name} {number}", _cut(made, frame)
        if not made.touching:
            for number, moved in zip(at, exactly_moved(wide.numbers.numpy(), field, arguments.size, at), strict=True):
                yield f"{name} {number} exact", _cut(wide, moved)


def _cut(made: Made, source: np.ndarray) -> dict[str, float]:
    return cut_elements(made.numbers.numpy(), source, made.touching)


def bench(arguments: argparse.Namespace) -> Iterator[Row]:
    """A row for each texture, size, seed and method; each seed makes another texture."""
    for name in arguments.textures:
        for element in arguments.sizes:
            for seed in range(arguments.seeds):
                progress(f"{name} {element}, seed {seed}")
                for method, cut in figures(arguments, name, element, seed):
                    yield Row(f"{name} {element}", method, "", cut)


def parsed(words: list[str] | None) -> argparse.Namespace:
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("textures", nargs="*", metavar="TEXTURE", help=f"of {', '.join(MADE)} (all)")
    parser.add_argument("--sizes", nargs="+", type=int, default=[12, 20, 32], help="of elements, px (12 20 32)")
    parser.add_argument("--side", type=int, default=128, help="of the exemplars, px (128)")
    parser.add_argument("--size", type=size, default=(256, 256), help="of the outputs, WIDTHxHEIGHT (256x256)")
    parser.add_argument("--seeds", type=int, default=2, help="how many (2)")
    parser.add_argument("--methods", nargs="*", choices=METHODS, default=list(METHODS), metavar="METHOD")
    parser.add_argument("--flows", nargs="*", choices=FIELDS, default=list(FIELDS), metavar="FIELD")
    parser.add_argument("--at", type=number_list, default=[0, 60, 150], help="frames to be judged (0,60,150)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too")
    arguments = parser.parse_args(words)
    if unknown := set(arguments.textures) - set(MADE):
        parser.error(f"no texture is named {', '.join(sorted(unknown))}; give some of {', '.join(MADE)}")
    arguments.textures = arguments.textures or list(MADE)
    return arguments


def run(arguments: argparse.Namespace) -> None:
    width = max(len(f"{name} {element}") for name in arguments.textures for element in arguments.sizes)
    rows = print_table(bench(arguments), FIGURES, width)
    if arguments.json is not None:
        arguments.json.write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n", encoding="utf-8")


def main(words: list[str] | None = None) -> int:
    arguments = parsed(words)
    return exit_code("bench_elements", lambda: run(arguments))


if __name__ == "__main__":
    sys.exit(main())
