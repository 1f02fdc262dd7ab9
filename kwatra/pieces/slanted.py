"""A start whose lines run obliquely, laid where they run along an axis: with each row moved by whole pixels.

Oblique lines can neither be cut out as long narrow boxes, nor does a seam between neighbors on the grid know whether it
runs beside them or across. With each row (or column) moved by as much as a line has gone aside there, both is as for
lines along an axis, and no pixel is mixed: a copy is moved back as it came if it lies a multiple of so many rows away
as make a whole step. The output's rows are closed in themselves, and so is it as if it went on beyond its sides.
"""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from kwatra.elements.slant import Slant
from kwatra.exemplar import Exemplar
from kwatra.pieces.blocks import BlockStart
from kwatra.pieces.boxes import Box


@dataclass(frozen=True)
class Upright:
    """The place of each pixel of an exemplar of a shape whose rows are moved aside, so that its lines are upright.

    Rows are columns where lines run rather to the right than down. grain: what the place where they begin is a multiple
    of.
    """

    slant: Slant
    shape: tuple[int, ...]
    grain: int = 1

    @property
    def room(self) -> int:
        """How far aside the leftmost line begins."""
        most = int(self.slant.moved(self.shape[self.slant.along]).max())
        return -(-most // self.grain) * self.grain

    def exemplar(self, exemplar: Exemplar) -> Exemplar:
        """The exemplar so; what lies beside it is nobody's."""
        moved, size = self.slant.moved(self.shape[self.slant.along]), self.shape[1 - self.slant.along]
        there = torch.arange(size + self.room - int(moved.min())) + moved[:, None] - self.room
        index = self._index(there.clamp(0, size - 1))
        inside = ((there >= 0) & (there < size)).movedim(0, self.slant.along).to(exemplar.owner.device)
        canvas, origin = (part[:, index[0], index[1]] for part in (exemplar.canvas, exemplar.origin))
        return replace(exemplar, canvas=canvas, origin=origin, owner=torch.where(inside, exemplar.owner[index], -1.0))

    def box(self, box: Box, size: int) -> Box:
        """The smallest that holds a box of an output whose moved rows have a size."""
        along = self.slant.along
        moved = self.slant.moved(box.stop[along])[box.start[along] :]
        start, extent = list(box.start), list(box.extent)
        start[1 - along] -= int(moved.max())
        extent[1 - along] = min(extent[1 - along] + int(moved.max() - moved.min()), size)
        return Box(tuple(start), tuple(extent))

    def back(self, where: Tensor) -> Tensor:
        """The source map (2, *S), in places of the exemplar as it was, of an output whose rows are moved."""
        along = self.slant.along
        on, aside = where.shape[1 + along], where.shape[2 - along]
        lines = (torch.arange(aside) - self.slant.moved(on)[:, None]) % aside
        rows, columns = self._index(lines)
        places = where[:, rows, columns]
        moved = self.slant.moved(self.shape[along]).to(places.device)
        places[1 - along] += moved[places[along]] - self.room
        return places

    def _index(self, lines: Tensor) -> tuple[Tensor, Tensor]:
        """The index of pixels (rows, n) of each row, turned where rows are columns."""
        rows = torch.arange(len(lines), device=lines.device)[:, None].expand_as(lines)
        return (rows, lines) if self.slant.along == 0 else (lines.T, rows.T)


class SlantedStart:
    """As `BlockStart`, of a single image whose lines run obliquely; neither does the output wrap nor anything steer it.

    block: its size where lines run along an axis. easier: how many times less seams cost there along each axis.
    """

    gaps = fitted = None

    def __init__(
        self,
        slant: Slant,
        exemplar: Exemplar,
        shape: Sequence[int],
        block: Sequence[int],
        grain: Sequence[int],
        generator: torch.Generator,
        *,
        usage: float,
        seams: int,
        easier: Sequence[float],
    ) -> None:
        along = slant.along
        self.upright = Upright(slant, exemplar.shape, grain[1 - along])
        steps = tuple(g * (slant.on if axis == along else 1) for axis, g in enumerate(grain))
        self.shape, self.wraps = tuple(shape), (False, False)
        self.blocks = BlockStart(
            self.upright.exemplar(exemplar),
            shape,
            tuple(max(b // g, 1) * g for b, g in zip(block, steps, strict=True)),
            steps,
            generator,
            wraps=[axis != along for axis in range(2)],
            usage=usage,
            seams=seams,
            along=along,
            easier=easier,
        )

    def run(self, draft: bool = False) -> Tensor:
        """Lay all blocks; the source map (2, *shape)."""
        self.blocks.run(draft)
        return self.where

    @property
    def draft(self) -> bool:
        """Whether blocks are laid once only."""
        return self.blocks.draft

    @property
    def where(self) -> Tensor:
        """The source map (2, *shape) of what is laid."""
        return self.upright.back(self.blocks.where)

    def afresh(self, generator: torch.Generator) -> "SlantedStart":
        """Another start, in which all blocks are laid from the beginning; this one stays as it is."""
        return self._of(self.blocks.afresh(generator))

    def refined(self, generator: torch.Generator) -> "SlantedStart":
        """What this draft becomes where blocks are laid again; this one stays as it is."""
        return self._of(self.blocks.refined(generator))

    def anew(self, part: Box, generator: torch.Generator) -> "SlantedStart":
        """Another start, in which blocks are laid anew where a part of the output is; this one stays as it is."""
        box = self.upright.box(part, self.shape[1 - self.upright.slant.along])
        return self._of(self.blocks.anew(box, generator))

    def _of(self, blocks: BlockStart) -> "SlantedStart":
        """The same of other blocks."""
        other = copy(self)
        other.blocks = blocks
        return other
