"""What repeats, and what that is good for: pieces laid in step, and a periodic picture continued exactly."""

from collections.abc import Sequence
from typing import NamedTuple

import torch
from torch import Tensor

from kwatra.elements.correlation import LEAST_OVERLAP
from kwatra.elements.kept import kept
from kwatra.elements.lattice import Lattice, find_lattice, reduced
from kwatra.elements.rows import Rows, find_rows
from kwatra.exemplar import Exemplar

LOOKED_AT = 2**17
"""A larger picture is halved for finding how it repeats until it has so many pixels: what repeats in fewer then, every
ten or so, hardly shows, and to find it would take longer than to lay its blocks."""

SAME = 1 / 255
"""Colors that differ by no more are the same: a step of 8 bits."""

MULTIPLES = 4
"""A picture whose lattice is no whole pixels is periodic in one of so many multiples of its vectors, or in none."""


@kept
def find_repeats(exemplar: Exemplar) -> Lattice | Rows | None:
    """The lattice of an image's texture, or else its rows; of a large one it is sought at a coarser resolution."""
    seen, factor = exemplar.halved_to(LOOKED_AT)
    found = find_lattice(seen) or find_rows(seen)
    return None if found is None else found.coarser(1 / factor)


def out_of_step(
    repeats: Lattice | Rows, first: Sequence[float], shape: Sequence[int], grain: Sequence[int] = (1, 1)
) -> Tensor:
    """How far translations are from the nearest one in step, in pixels, (*shape).

    The map's translation at (i, j) is `first` + (i, j) * grain, an offset (down, right) between output and exemplar
    less one that is known to be in step: that of the piece laid first, or of a neighbor. It says nothing of offsets
    into another image of the exemplar, in which all stands elsewhere.
    """
    axes = [
        start + step * torch.arange(size, dtype=torch.float32)
        for start, size, step in zip(first, shape, grain, strict=True)
    ]
    rest = repeats.rest(torch.stack(torch.meshgrid(*axes, indexing="ij")))
    return rest.square().sum(0).sqrt()  # `norm` takes many times as long


class Cell(NamedTuple):
    """Where on a canvas the cell is copied from by which an image is periodic.

    places (n,): of each of its pixels, counted row by row in the image; width, corner: the image's, and where it lies.
    basis: the lattice as vectors (down, right) and (0, along).
    """

    places: Tensor
    width: int
    corner: list[int]
    basis: tuple[int, int, int]


@kept
def find_cell(exemplar: Exemplar) -> Cell | None:
    """The cell of an exemplar's first image that is exactly periodic, None where none is.

    It repeats in whole pixels, each color to within a step of 8 bits, and a whole cell of it may be copied. None of one
    so large that its lattice is not looked for at its own resolution (LOOKED_AT).
    """
    lattice = find_lattice(exemplar) if exemplar.owner.numel() <= LOOKED_AT else None
    if lattice is None:
        return None
    for box, inside in exemplar.places():
        image = exemplar.canvas[(slice(None), *box)]
        vectors = _exact(image, inside, lattice)
        if vectors is None:
            continue
        basis = _triangular(vectors)
        place = _innermost_of_cell(inside, basis)
        if bool((place >= 0).all()) and _alike(image, inside, place[_cell(inside.shape, basis)]):
            return Cell(place, inside.shape[1], [side.start for side in box], basis)
    return None


def continued(exemplar: Exemplar, shape: Sequence[int], first: Sequence[int] | None = None) -> Tensor | None:
    """The source map (2, *shape) that continues an image that is periodic exactly (`find_cell`), None where none is.

    first: where on the canvas the map begins, though it be outside of the image; None for the image's upper left
    corner.
    """
    cell = find_cell(exemplar)
    if cell is None:
        return None
    start = [a - b for a, b in zip(cell.corner if first is None else first, cell.corner, strict=True)]
    there = cell.places[_cell(shape, cell.basis, start)]
    at = torch.stack([there // cell.width + cell.corner[0], there % cell.width + cell.corner[1]])
    return at.to(exemplar.canvas.device)


def _exact(image: Tensor, inside: Tensor, lattice: Lattice) -> Tensor | None:
    """The shortest whole vectors (2, 2) by which an image is the same where it overlaps itself."""
    steps = torch.cartesian_prod(*[torch.arange(-MULTIPLES, MULTIPLES + 1)] * 2).double()
    moves = (steps @ lattice.vectors).round().long()
    moves = moves[moves.square().sum(1).argsort(stable=True)]
    first: Tensor | None = None
    for move in moves[moves.any(1)]:
        if first is not None and int(first[0] * move[1] - first[1] * move[0]) == 0:
            continue
        if _repeats(image, inside, move.tolist()):
            if first is not None:
                return reduced(torch.stack([first, move]).double()).long()
            first = move
    return None


def _repeats(image: Tensor, inside: Tensor, move: Sequence[int]) -> bool:
    """Whether an image moved is the image, where enough of the two overlaps."""
    here = tuple(slice(max(m, 0), max(s + min(m, 0), 0)) for m, s in zip(move, inside.shape, strict=True))
    there = tuple(slice(max(-m, 0), max(s - max(m, 0), 0)) for m, s in zip(move, inside.shape, strict=True))
    both = inside[here] & inside[there]
    if int(both.sum()) < LEAST_OVERLAP * int(inside.sum()):
        return False
    difference = (image[(slice(None), *here)] - image[(slice(None), *there)]).abs().amax(0)
    return float(difference[both].max()) <= SAME


def _triangular(vectors: Tensor) -> tuple[int, int, int]:
    """The same lattice as whole vectors (2, 2) spanned by (down, right) and (0, along): down, right, along."""
    (a, b), (c, d) = vectors.tolist()
    area = abs(a * d - b * c)
    while c:  # Euclid's algorithm on the first coordinates
        times = a // c
        a, b, c, d = c, d, a - times * c, b - times * d
    down, right = (a, b) if a > 0 else (-a, -b)
    return down, right, area // down


def _cell(shape: Sequence[int], basis: tuple[int, int, int], first: Sequence[int] = (0, 0)) -> Tensor:
    """Number (*shape) of each pixel's place in the lattice's cell, from a first pixel on.

    Pixels a lattice vector apart have the same.
    """
    down, right, along = basis
    lines = (torch.arange(start, start + size) for start, size in zip(first, shape, strict=True))
    y, x = torch.meshgrid(*lines, indexing="ij")
    return (y % down) * along + (x - y // down * right) % along


def _innermost_of_cell(inside: Tensor, basis: tuple[int, int, int]) -> Tensor:
    """For each place in the cell that of the image's pixels (flat) which has it farthest inside, -1 without one."""
    down, _, along = basis
    pixels = inside.flatten().nonzero()[:, 0]
    height, width = inside.shape
    y, x = pixels // width, pixels % width
    margin = torch.stack([y, height - 1 - y, x, width - 1 - x]).amin(0)
    pixels = pixels[(-margin).argsort(stable=True)]
    numbers = _cell(inside.shape, basis).flatten()[pixels]
    order = torch.arange(len(pixels))
    first = order.new_full((down * along,), len(pixels)).scatter_reduce(0, numbers, order, "amin")
    return torch.where(first < len(pixels), pixels[first.clamp(max=len(pixels) - 1)], -1)


def _alike(image: Tensor, inside: Tensor, place: Tensor) -> bool:
    """Whether an image is the same as with its pixels replaced by those at `place` (flat)."""
    difference = (image - image.flatten(1)[:, place]).abs().amax(0)
    return float(difference[inside].max()) <= SAME
