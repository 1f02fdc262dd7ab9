"""Worn texture is renewed: what is left of the energy's minimization for a frame that was carried along.

A frame carried along is x+, the best there is for the flow term (x - x+)^T K (x - x+) (thesis equation 27). What it
loses is texture: copies of the exemplar are bent, what they show goes out of proportion, and where they meet they
cease to agree. So the texture energy (thesis equation 18) is measured, window by window; where it is highest, blocks
of the exemplar are found that come closest to what is there; and of each block those pixels are taken that lower

    U(x) = sum_p wear(p) + sum_p tone(p) + lambda sum_p K(p) |x(p) - x+(p)|^2 + seams,

by a minimum cut (a fusion of two labelings: Lempitsky, Rother, Roth and Blake 2010). Windows are copied, never
averaged, so nothing blurs; and a pixel changes only where that buys more texture than it costs in motion.
"""

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from flow.animation.blocks import Blocks
from flow.animation.copies import JUMP, softened
from flow.animation.fusion import seam_cut
from flow.animation.reading import Reading
from flow.animation.settings import Renewing
from flow.animation.term import gradient_weight
from flow.animation.tones import Tones
from flow.animation.wear import Wear
from flow.warps import pixel_coordinates
from kwatra import Exemplar
from kwatra.base import mean, total
from kwatra.cut import FREE, KEEP, TAKE, VOID

_LEAST = 0.005
"""Blocks with less wear than this, on average, are left as they are."""

_RIM = 1 / 6
"""The part of a block's side, at either end, over which what it saves in wear counts less, down to nothing."""

_AGAIN = 1 / 8
"""A block is a copy found again when at least so much of it is there already."""

_BETWEEN = 4
"""Blocks start at multiples of this many px, and flush with the frame's borders."""


@dataclass
class Carried:
    """A frame at work: source coordinates (2, H, W), the image (C, H, W) they show, wear (H, W), where coordinates are
    usable (H, W), and what each tone costs.
    """

    source: Tensor
    image: Tensor
    wear: Tensor
    usable: Tensor
    prices: Tensor


class Renewal:
    """Renews frames of `shape` (H, W) with texture from an exemplar."""

    def __init__(self, exemplar: Exemplar, shape: tuple[int, int], settings: Renewing) -> None:
        self.exemplar, self.shape, self.settings = exemplar, shape, settings
        self.wear = Wear(exemplar, shape, settings.window, settings.step, settings.area)
        self.tones = Tones(exemplar, settings.tones)
        self.read = Reading(exemplar, settings.interpolation)
        self.blocks = Blocks(exemplar, min(settings.block, *shape))
        self._pixels = pixel_coordinates(shape, exemplar.canvas.device)
        self._share = exemplar.share
        t = (torch.arange(self.blocks.size) - (self.blocks.size - 1) / 2) / (0.4 * self.blocks.size)
        bell = torch.exp(-t.square()).to(exemplar.canvas.device)
        self._bell = bell[:, None] * bell
        inner = (torch.arange(self.blocks.size) / (_RIM * self.blocks.size)).clamp(max=1).to(exemplar.canvas.device)
        inner = inner.minimum(inner.flip(0))
        self._inner = inner[:, None].minimum(inner)

    def __call__(
        self, source: Tensor, inside: Tensor, generator: torch.Generator, moved: Tensor | None = None
    ) -> tuple[Tensor, Tensor, dict[str, float]]:
        """Renew a carried frame: its source coordinates (2, H, W), image (C, H, W), and what that took.

        inside (H, W): True where texture belongs; elsewhere coordinates are left alone. generator: chooses what enters
        where there is nothing to agree with. moved (H, W): where texture can have worn at all (default: everywhere).
        The report holds "texture", mean wear before; "flow", mean change; and "renewed", the share of pixels.
        """
        usable = self.read.usable(source)
        image = self.read(source)
        prices = self.tones.prices(source, inside & usable)
        wear = self._worn(image, source, inside & usable if moved is None else inside & usable & moved, prices)
        frame = Carried(source.clone(), image.clone(), wear.clone(), usable.clone(), prices)
        cost = self.settings.flow_weight * gradient_weight(image, self._share) / self.wear.variance
        lost = inside & self.read.lost(source)
        self._renew(frame, cost, inside, self._places(wear, lost), generator)
        while bool((lost := lost & ~frame.usable).any()):
            self._renew(frame, cost, inside, self._places(torch.zeros_like(wear), lost), generator)
        changed = inside & usable & (frame.source != source).any(0)
        area = total(inside.float()).clamp(min=1)
        flow = total(((frame.image - image).square() * self._share).sum(0) * changed) / self.wear.variance
        return frame.source, softened(frame.image, frame.source, inside, self.read), {
            "texture": float(total(wear) / area),
            "flow": float(flow / area),
            "renewed": float(total(changed.float()) / area),
        }  # fmt: skip

    def _worn(self, image: Tensor, source: Tensor, inside: Tensor, prices: Tensor) -> Tensor:
        wear = self.wear(image, source, inside) + prices[self.tones.of(source)]
        return (wear - self.settings.tolerance).clamp(min=0) * inside

    def _places(self, wear: Tensor, lost: Tensor) -> list[tuple[int, int]]:
        """Corners (row, column) of the blocks to renew: those most worn, and all that have lost their texture."""
        size = self.blocks.size
        rows, columns = (_starts(side, size) for side in self.shape)
        worn = _block_sums(wear, rows, columns, size) / size**2
        holes = _block_sums(lost.float(), rows, columns, size)
        need = np.where(holes > 0.5, 10 + holes, np.where(worn > _LEAST, worn, 0))
        places: list[tuple[int, int]] = []
        while need.max() > 0:
            row, column = np.unravel_index(int(need.argmax()), need.shape)
            if len(places) >= self.settings.blocks and need[row, column] < 10:
                break
            places.append((int(rows[row]), int(columns[column])))
            near = (np.abs(rows - rows[row]) < 3 / 8 * size)[:, None] & (
                np.abs(columns - columns[column]) < 3 / 8 * size
            )
            need[near] = 0
        return places

    def _renew(
        self, frame: Carried, cost: Tensor, inside: Tensor, places: list[tuple[int, int]], generator: torch.Generator
    ) -> None:
        """Find a block for each place and take of it what lowers the energy."""
        if not places:
            return
        size = self.blocks.size
        spots = [(slice(row, row + size), slice(column, column + size)) for row, column in places]
        content = torch.stack([frame.image[(slice(None), *spot)] for spot in spots])
        known = torch.stack([(inside & frame.usable)[spot] * self._bell for spot in spots])[:, None]
        corners = self.blocks.nearest(content, known, self._costs(frame, inside), generator)
        for spot, corner in zip(spots, corners, strict=True):
            source = self._pixels[(slice(None), *spot)]
            source = source - source[:, :1, :1] + corner.view(2, 1, 1)
            self._fuse(frame, spot, self._in_place(frame, spot, source), cost[spot], inside[spot])

    def _in_place(self, frame: Carried, spot: tuple[slice, slice], source: Tensor) -> Tensor:
        """A block's source coordinates, moved by the fraction of a pixel that it is off the copy already there.

        So a copy found again is straightened where it lies and does not jump; other blocks stay whole pixels.
        """
        off = frame.source[(slice(None), *spot)] - source
        again = frame.usable[spot] & (off.square().sum(0) < JUMP**2)
        if float(again.float().mean()) < _AGAIN:
            return source
        moved = source + off[:, again].median(1).values.view(2, 1, 1)
        return moved if bool(self.read.usable(moved).all()) else source

    def _costs(self, frame: Carried, inside: Tensor) -> Tensor:
        """What using each exemplar pixel (canvas) once more costs: by how much it is used already, and its tone."""
        height, width = self.exemplar.shape
        x, y = frame.source[:, inside].round().long()
        place = y.clamp(0, height - 1) * width + x.clamp(0, width - 1)
        used = torch.bincount(place, minlength=height * width).view(height, width).float()
        usage = self.settings.usage * used / mean(used).clamp(min=1e-6)
        return self.wear.variance * (usage + self.tones.costs(frame.prices))

    def _fuse(self, frame: Carried, spot: tuple[slice, slice], source: Tensor, cost: Tensor, inside: Tensor) -> None:
        """Take of a block, given by its source coordinates, the pixels that lower the energy.

        Wear counts less toward the block's rim, so that seams run where copies agree and not along the rim.
        """
        here = (slice(None), *spot)
        usable, new, old = frame.usable[spot], self.read(source), frame.image[here]
        change = ((new - old).square() * self._share).sum(0) * usable
        tones = frame.prices[self.tones.of(source)]
        taking = torch.where(usable, cost * change + tones - frame.wear[spot] * self._inner, 0.0)
        rough = (change / self.wear.variance).sqrt() * self.settings.seam
        state = torch.where(inside, FREE, VOID)
        state[self._rim(spot) & inside & usable] = KEEP
        state[inside & ~usable] = TAKE
        take = torch.from_numpy(seam_cut(state, rough, taking)).to(new.device)
        frame.source[here] = torch.where(take, source, frame.source[here])
        frame.image[here] = torch.where(take, new, old)
        frame.wear[spot] = torch.where(take, 0.0, frame.wear[spot])
        frame.usable[spot] = usable | take

    def _rim(self, spot: tuple[slice, slice]) -> Tensor:
        """The block's outermost pixels, but for those on the frame's border."""
        size = self.blocks.size
        rim = torch.zeros(size, size, dtype=torch.bool, device=self._pixels.device)
        for axis, (part, side) in enumerate(zip(spot, self.shape, strict=True)):
            if part.start > 0:
                rim.select(axis, 0).fill_(True)
            if part.stop < side:
                rim.select(axis, size - 1).fill_(True)
        return rim


def _starts(side: int, size: int) -> np.ndarray:
    starts = np.arange(0, side - size + 1, _BETWEEN)
    return starts if starts[-1] == side - size else np.append(starts, side - size)


def _block_sums(values: Tensor, rows: np.ndarray, columns: np.ndarray, size: int) -> np.ndarray:
    """Sums of values (H, W) over the blocks that start at rows and columns, by a summed-area table."""
    table = np.pad(values.double().cpu().numpy().cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    strips = table[rows + size] - table[rows]
    return strips[:, columns + size] - strips[:, columns]
