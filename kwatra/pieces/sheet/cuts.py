"""Patches, and how they are cut for the windows that they are laid in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Array
from kwatra.pieces.sheet.window import Window, Windows


@dataclass(frozen=True)
class Patch:
    """Source `number` shifted so that its pixel x lies at output pixel x + `shift`, and cut to `box`.

    A shift is whole where places are whole (see `Stock`), and may else be a fraction of a pixel.
    """

    number: int
    shift: tuple[Any, ...]
    box: Box

    def moved(self, steps: int) -> Patch:
        """The same patch so many steps further along axis 0."""
        start = (self.box.start[0] + steps, *self.box.start[1:])
        return Patch(self.number, (self.shift[0] + steps, *self.shift[1:]), Box(start, self.box.extent))

    def scaled(self, by: tuple[int, ...], shape: tuple[int, ...]) -> Patch:
        """The same patch where every axis is so many times longer, on an output of `shape`."""
        shift, start, extent = (
            tuple(v * f for v, f in zip(values, by, strict=True))
            for values in (self.shift, self.box.start, self.box.extent)
        )
        return Patch(self.number, shift, Box(start, extent).clipped(shape, (False,) * len(shape)))


class Cut(NamedTuple):
    """A patch cut for the pixels of a window: which of them `take` it, its `places` there, `seams` after.

    change: by how much the total of the seams changes; price: that, and what taking costs besides.
    """

    patch: Patch
    window: Window
    take: np.ndarray
    places: np.ndarray
    seams: list[np.ndarray]
    change: int
    price: int


@dataclass(frozen=True, eq=False)
class Cuts:
    """Patches cut for windows, each as a `Cut`, None where none is; take, places, seams: flat, as in `Pixels`.

    changes, prices (b,): whole numbers.
    """

    windows: Windows
    patches: list[Patch | None]
    take: Array
    places: Array
    seams: Array
    changes: Array
    prices: Array

    @classmethod
    def of(cls, cut: Cut) -> Cuts:
        """One alone."""
        change, price = np.array([cut.change]), np.array([cut.price])
        seams = np.concatenate([cost.ravel() for cost in cut.seams])
        return cls(Windows.alone(cut.window), [cut.patch], cut.take.ravel(), cut.places.ravel(), seams, change, price)

    def __len__(self) -> int:
        return len(self.patches)

    def __getitem__(self, number: int) -> Cut | None:
        """That for one window."""
        patch, windows = self.patches[number], self.windows
        if patch is None:
            return None
        shown = windows.of_pixels(self.take, number), windows.of_places(self.places, number)
        left = windows.of_pairs(self.seams, number)
        return Cut(patch, windows[number], *shown, left, int(self.changes[number]), int(self.prices[number]))

    def put(self, number: int, cut: Cut | None) -> None:
        """Have another cut for one window."""
        if cut is None:
            self.patches[number] = None
            return
        self.patches[number], self.changes[number], self.prices[number] = cut.patch, cut.change, cut.price
        self.windows.of_pixels(self.take, number)[:] = cut.take
        self.windows.of_places(self.places, number)[:] = cut.places
        for part, cost in zip(self.windows.of_pairs(self.seams, number), cut.seams, strict=True):
            part[:] = cost
