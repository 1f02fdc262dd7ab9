"""Seams along the gaps between elements, where a texture has any, or else along the outlines of those that touch."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.elements import Ground, find_ground, find_outlines
from kwatra.elements.size import LOOKED_AT
from kwatra.exemplar import Exemplar
from kwatra.pieces.seams.cost import Depth, SeamCost
from kwatra.pieces.seams.keeping import cheaper
from kwatra.pieces.seams.mosaic import Mosaic, by_place
from kwatra.pieces.seams.stock import Array

SURE = 0.1
"""Ground that hides seams less surely is taken for none; half and twice as much is as good on four textures."""

AROUND = 1.2
"""Blocks overlap by so many elements: with less there often is no way around one."""

CUTTING = 0.1
"""What a seam through an element costs at least, in standard deviations of the exemplar: a cut is seen even where
colors are alike. Tuned, with AROUND, on made stones and coins."""

WIDEST = 0.5
"""The most of a block that lies on others, where that lets seams run along gaps between elements."""

LARGEST = 0.75
"""The most of the exemplar that a block shows which has grown by its wider overlap, so that it adds as much as before.

Made stones and coins of 20 and 32 pixels are cut less by blocks that grow, .106 for .138; nuts score better."""

ALIGNED = 0.5
"""What it counts beside the colors that the gaps of a block lie where gaps are, each in what the texture affords.

Stones of many colors agree nowhere: of blocks of made stones, coins, letters and tiles of 20 and 32 px .093 are cut
with 0, .061 with .5 and .057 with 2. Seven photographs with gaps score .0512 with 0, .0517 with .5, .053 with 1."""


class Gaps(NamedTuple):
    """What seams of a mosaic cost that are hidden in gaps, and by how many pixels blocks overlap to reach one.

    hidden: where in the exemplar that is.
    """

    mosaic: Mosaic
    cost: SeamCost
    overlap: int
    hidden: "Hidden"

    @property
    def weight(self) -> float:
        """What it counts beside the colors of blocks that their gaps disagree."""
        return ALIGNED * self.hidden.hides

    def widened(
        self, block: Sequence[int], overlap: Sequence[int], room: Sequence[float], grain: Sequence[int]
    ) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Blocks, a multiple of grain, and their overlaps, so wide that seams can run along gaps, axis by axis.

        room: to how many pixels blocks may grow; they do so as much as overlaps.
        """
        blocks, overlaps = [], []
        for b, least, most, g in zip(block, overlap, room, grain, strict=True):
            wide = max(least, min(self.overlap, round(WIDEST * b)))
            blocks.append(max(min(-(-(b + wide - least) // g) * g, int(most) // g * g), b))
            overlaps.append(wide)
        return tuple(blocks), tuple(overlaps)

    def cheaper(self, before: Tensor, after: Tensor, wraps: Sequence[bool] = ()) -> Tensor:
        """Where (boolean, *S) to go over from a source map (n, *S) to a later one, so that seams cost least.

        wraps: along which axes they are periodic; none by default.
        """
        earlier, later = (self.mosaic.places_of(list(where.cpu().numpy())) for where in (before, after))
        return torch.from_numpy(cheaper(self.cost, earlier, later, wraps)).to(before.device)


class Hidden(NamedTuple):
    """depth (*S): what seams cost at each place of an exemplar's canvas, 0 where they are hidden to 1.

    hides: 0 to 1, how well the gaps hide them. size: that of an element, in pixels. aligned: what it counts beside the
    colors that gaps lie on gaps, where they hide seams fully. dearer: how many times as much as usual a seam costs more
    through an element. parts (*S): those that meet at outlines, beside which alone seams are hidden; None of elements
    that are apart. long: whether they are parted by thin lines, and long.
    """

    depth: Array
    hides: float
    size: float
    aligned: float
    dearer: float
    parts: Array | None = None
    long: bool = False

    @property
    def unlike(self) -> Array:
        """The depth (*S) about its mean, in standard deviations: by how much places are told apart."""
        away = self.depth - self.depth.mean()
        unlike: Array = away / max(float(away.std()), 1e-9)
        return unlike

    def finer(self, factor: int, shape: Sequence[int]) -> "Hidden":
        """The same of an exemplar (*shape) of `factor` times the resolution; its last pixels may make no whole one."""
        beyond = [(0, max(size - factor * there, 0)) for size, there in zip(shape, self.depth.shape, strict=True)]

        def enlarged(values: Array) -> Array:
            return np.pad(values, beyond, mode="edge")

        depth = F.interpolate(torch.from_numpy(self.depth)[None, None], scale_factor=factor, mode="bilinear")[0, 0]
        parts = None if self.parts is None else enlarged(self.parts.repeat(factor, 0).repeat(factor, 1))
        return self._replace(depth=enlarged(depth.numpy()), size=factor * self.size, parts=parts)

    def cost(self, mosaic: Mosaic, sources: Sequence[Any], deviation: float) -> SeamCost:
        """What seams of a mosaic cost, more through elements.

        sources: for each of the mosaic's the index of the exemplar's pixels that it shows; deviation: the standard
        deviation of colors, in the mosaic's units.
        """

        def lookup(values: Array) -> Callable[[Array], Array]:
            return np.concatenate([by_place(values[shown]) for shown in sources]).__getitem__

        least = CUTTING * self.dearer * self.hides * deviation
        part = None if self.parts is None else lookup(self.parts)
        return SeamCost(mosaic, depth=Depth(lookup(self.depth), least, part=part))


def hidden_seams(exemplar: Exemplar) -> Hidden | None:
    """Where gaps between elements of still images hide seams, or else outlines; None if nothing does."""
    return found_coarser(_hidden_seams, exemplar)


def found_coarser(find: Callable[[Exemplar], Hidden | None], exemplar: Exemplar) -> Hidden | None:
    """What is found to hide seams of still images; those of more than `LOOKED_AT` pixels are looked at coarser.

    So the size of their elements is found, and so are they laid.
    """
    seen, factor = exemplar.halved_to(LOOKED_AT)
    hidden = find(seen)
    return hidden if hidden is None or factor == 1 else hidden.finer(factor, exemplar.shape)


def _hidden_seams(exemplar: Exemplar) -> Hidden | None:
    ground = find_ground(exemplar)
    if ground.hides >= SURE:
        return hidden_along(ground, ground.hides)
    found = find_outlines(exemplar)
    if found is None:
        return None
    return Hidden(_seen(found.depth, found.hides), found.hides, found.size, ALIGNED, 1.0, found.parts)


def hidden_along(ground: Ground, hides: float, aligned: float = ALIGNED, dearer: float = 1.0) -> Hidden:
    """Where seams are hidden by some ground that hides them so well, 0 to 1; the rest is as in `Hidden`."""
    return Hidden(_seen(ground.depth, hides), hides, ground.size, aligned, dearer, long=ground.long)


def _seen(depth: Array, hides: float) -> Array:
    """What seams cost (*S) by depth where what is at 0 hides them so well."""
    seen: Array = (1 - hides * (1 - depth)).astype(np.float32)
    return seen


def find_gaps(exemplar: Exemplar, mosaic: Mosaic, deviation: float) -> Gaps | None:
    """The gaps or outlines of an exemplar of still images, None without any that hide seams.

    mosaic: its canvas; deviation: the standard deviation of its colors, in the mosaic's units.
    """
    hidden = hidden_seams(exemplar)
    if hidden is None:
        return None
    cost = hidden.cost(mosaic, [...], deviation)
    return Gaps(mosaic, cost, round(AROUND * hidden.hides * hidden.size), hidden)
