"""What a still's kept pixels are to its texture: copies of the exemplar, more of its like, or foreign to it.

Blocks that an output begins with go on from copies as from each other: in step with rows and lattices, around whole
elements. From what is foreign, as writing or what stands in front of a wall, no block goes on, and to agree with it
only tears them, so they are laid as if it hid them. Which is which is told part by part, by the values alone.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
import torch
import torch.nn.functional as F
from scipy import ndimage
from torch import Tensor

from kwatra.base import running
from kwatra.exemplar import Exemplar
from kwatra.pieces.choosing import variance
from kwatra.terms import HardPixels, TermLike
from kwatra.windows import channels_last, windows_at

WIDTH = 8
"""Of the windows that are compared, px. Pixels that are no further apart are of one part, as strokes of a word are."""

SAMPLES, OTHERS = 48, 2**13
"""So many windows of a part are compared with so many of the exemplar, evenly spread over both."""

FOREIGN = 1.0
"""A part is foreign whose windows differ by more variances, in the median, from those of the exemplar most like them.

Of 52 exemplars a half differs from the other by .71 at most, .18 in the median; black, white, red and blue writing by
5.3 in the median, and by less than this in .18 of all cases, where the texture has that color."""

SAME = 0.05
"""A part is a copy that differs by fewer variances, on average, from a place of the exemplar, as .92 of 52 pictures do
from themselves saved as JPEG of quality 85."""

LOOKED_FOR, TRIED = 16, 16
"""So many parts, the largest, are looked for in the exemplar, each at so many places that are most like it."""


def recognized(terms: tuple[TermLike, ...], exemplar: Exemplar) -> tuple[TermLike, ...]:
    """A still's terms as its blocks see them: hard pixels tell what they are copied from, foreign ones are left out.

    Only pixels count of which all channels are hard, of terms that tell no source yet. Memory: `SAMPLES` times `OTHERS`
    distances, and a few images.
    """
    known = _Known(exemplar)
    seen = [_seen(term, known) if isinstance(term, HardPixels) and term.source is None else term for term in terms]
    return tuple(term for term in seen if term is not None)


def _seen(term: HardPixels, known: "_Known") -> HardPixels | None:
    """Hard pixels that tell the source of copies, without what is foreign; None if there is nothing else."""
    hard = (term.where == 1).expand_as(term.target).all(0)
    if not bool(hard.any()) or not len(known.corners):
        return term
    source, foreign = torch.full((2, *hard.shape), -1, device=hard.device), torch.zeros_like(hard)
    for number, (box, part) in enumerate(_parts(hard)):
        values = torch.where(part, term.target[:, *box], 0.0) * known.root
        places = known.places(values, part) if number < LOOKED_FOR else None
        if places is not None:
            source[:, *box] = torch.where(part, places, source[:, *box])
        elif known.unlike(values, part) > FOREIGN:
            foreign[box] |= part
    where = torch.where(foreign, torch.zeros_like(term.where), term.where)
    if not bool((where > 0).any()):
        return None
    return replace(term, where=where, source=source if bool((source >= 0).any()) else None)


def _parts(hard: Tensor) -> Iterator[tuple[tuple[slice, ...], Tensor]]:
    """The parts of pixels (*S) that lie apart, the largest first: the box of each, and which pixels of it are its."""
    around = ndimage.maximum_filter(hard.cpu().numpy(), WIDTH + 1)
    number = np.where(hard.cpu().numpy(), ndimage.label(around)[0], 0)
    sizes = np.bincount(number.ravel())
    boxes = ndimage.find_objects(number)
    for part in 1 + np.argsort(-sizes[1:], kind="stable"):
        box = boxes[part - 1]
        yield box, torch.from_numpy(number[box] == part).to(hard.device)


class _Known:
    """An exemplar that parts of an image are looked for in; their values (C, *S) are times the `root` of its shares."""

    def __init__(self, exemplar: Exemplar) -> None:
        self.exemplar, self.owned, self.root = exemplar, exemplar.owner >= 0, exemplar.share.sqrt()

    @cached_property
    def image(self) -> Tensor:
        """All that may be copied (C, *S), 0 elsewhere."""
        return torch.where(self.owned, self.exemplar.canvas, 0.0) * self.root

    @cached_property
    def variance(self) -> float:
        """That of all channels by their shares."""
        return variance(self.exemplar, None)

    @cached_property
    def corners(self) -> Tensor:
        """The first pixels (N, 2) of all windows without holes."""
        return self.exemplar.corners((WIDTH, WIDTH)).nonzero()

    @cached_property
    def windows(self) -> Tensor:
        """Some of them, one a line (N, WIDTH * WIDTH * C)."""
        return _windows(self.image, _spread(self.corners, OTHERS)).flatten(1)

    @cached_property
    def squares(self) -> Tensor:
        """Their squares."""
        return self.windows.square()

    @cached_property
    def lengths(self) -> Tensor:
        """The squared length of the window at every position (A, B)."""
        ones = torch.ones(1, 1, WIDTH, WIDTH, device=self.image.device)
        return F.conv2d(self.image.square().sum(0)[None, None], ones)[0, 0]

    def unlike(self, values: Tensor, part: Tensor) -> float:
        """By how many variances windows around pixels of a part (*S) differ from those here most like them, the median.

        What of a window is not of the part does not count.
        """
        pixels, edge = _spread(part.nonzero(), SAMPLES), [WIDTH // 2] * 4
        own = _windows(F.pad(values, edge), pixels).flatten(1)
        counts = _windows(F.pad(part.expand_as(values).float(), edge), pixels).flatten(1)
        apart = own.square().sum(1)[:, None] - 2 * own @ self.windows.T + counts @ self.squares.T
        each = apart.amin(1) * len(values) / counts.sum(1)
        return float(each.median()) / self.variance

    def places(self, values: Tensor, part: Tensor) -> Tensor | None:
        """Where the pixels of a part (*S) are copied from, (2, *S); None if it is no copy."""
        if min(part.shape) < WIDTH:
            return None
        corners = _spread(running(torch.logical_and, part, (WIDTH, WIDTH)).nonzero(), SAMPLES)
        if not len(corners):
            return None
        windows = _windows(values, corners)
        richest = int(windows.flatten(1, 2).var(1).sum(1).argmax())
        for first in self._most_like(windows[richest], corners[richest], part.shape):
            box = tuple(slice(start, start + size) for start, size in zip(first, part.shape, strict=True))
            apart = (values - self.image[:, *box]).square().sum(0)[part]
            if bool(self.owned[box][part].all()) and float(apart.mean()) < SAME * self.variance:
                there = torch.meshgrid(*(torch.arange(line.start, line.stop) for line in box), indexing="ij")
                return torch.stack(there).to(part.device)
        return None

    def _most_like(self, window: Tensor, corner: Tensor, shape: Sequence[int]) -> list[list[int]]:
        """Where boxes of a shape begin that are most like a window at a corner of them, the most like first."""
        apart = self.lengths - 2 * F.conv2d(self.image[None], window.movedim(-1, 0)[None])[0, 0]
        firsts = self.corners - corner
        room = torch.tensor(self.owned.shape) - torch.tensor(shape)
        fitting = ((firsts >= 0) & (firsts <= room.to(firsts.device))).all(1)
        best = apart[tuple(self.corners[fitting].T)].sort(stable=True).indices[:TRIED]
        return firsts[fitting][best].tolist()


def _spread(corners: Tensor, most: int) -> Tensor:
    """At most so many of the corners (N, 2), evenly spread over them."""
    count = min(most, len(corners))
    return corners[torch.linspace(0, max(len(corners) - 1, 0), count, dtype=torch.float64).long()]


def _windows(image: Tensor, corners: Tensor) -> Tensor:
    """Windows (N, *width, C) of an image (C, *S)."""
    return windows_at(channels_last(image), corners, (WIDTH, WIDTH))
