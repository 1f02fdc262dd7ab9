"""Pasted neighborhoods shifted until they agree with those they overlap (Ruiters et al. 2010, section 4.4).

The energy is what overlapping neighborhoods differ by, and springs that hold neighbors at their distance:

    E = sum_x sum_p g_p(x) |z_p(x) - m(x)|^2 + stiffness sum_(p,q) |d_p - d_q|^2 / reach^2

with z_p the neighborhood of window p at its shifted place, g_p its falloff there, m(x) the mean of all at a pixel, d_p
how far p was shifted, and q the neighbors of p. Windows are gone through one after the other; each moves to the place,
of those within `reach` pixels of where it was first, where E is least, the others as they are: so E never rises.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from kwatra import Ballot, FreeWindows, Pull
from kwatra.base.compiled import jitted
from kwatra.steps.votes import Vote
from kwatra.windows import Layout

Array = NDArray[np.float32]
Places = NDArray[np.int64]


@dataclass(frozen=True)
class Relaxed:
    """A vote of windows that were shifted first.

    vote: which follows. reach: pixels a window may be shifted along each axis. stiffness: of the springs, in squared
    colors: with ten times as much no window of a photograph moved. sweeps: so often all windows are gone through, or
    less when none moves.
    """

    vote: Vote
    reach: int = 2
    stiffness: float = 0.001
    sweeps: int = 3

    def __call__(self, ballot: Ballot) -> Pull:
        """The vote. Memory: all windows, and three images."""
        layout, _ = relaxed(ballot, self.reach, self.stiffness, self.sweeps)
        return self.vote(Ballot(layout, ballot.source, ballot.matches, ballot.weights))


def relaxed(ballot: Ballot, reach: int, stiffness: float, sweeps: int) -> tuple[FreeWindows, list[float]]:
    """The windows (two axes) where they agree best, and the energy at first and after each sweep."""
    layout, source = ballot.layout, ballot.source
    windows = source.windows(ballot.matches) * source.metric.share.sqrt()
    corners = layout.corners.numpy().astype(np.int64)
    energies, places = _relax(
        np.ascontiguousarray(windows.numpy()), corners, *_springs(layout),
        source.metric.falloff[..., 0].numpy(), np.array(layout.shape), np.array(layout.wraps), reach,
        stiffness / max(reach, 1) ** 2, sweeps,
    )  # fmt: skip
    return FreeWindows(layout.shape, layout.width, torch.from_numpy(places), layout.wraps), energies


def _springs(layout: Layout) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Which windows each is held to, one after the other, and where each one's begin; held means both ways."""
    own = torch.arange(len(layout))
    pairs = torch.cat([torch.stack([own, number], 1) for number, _ in layout.neighbor_shifts()])
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    pairs = torch.cat([pairs, pairs.flip(1)]).unique(dim=0)
    first = torch.searchsorted(pairs[:, 0].contiguous(), torch.arange(len(layout) + 1))
    return pairs[:, 1].contiguous().numpy(), first.numpy()


@jitted
def _relax(
    windows: Array, corners: Places, held: Places, first: Places, falloff: Array, shape: Places, wraps: Any,
    reach: int, stiffness: float, sweeps: int,
) -> tuple[list[float], Places]:  # fmt: skip
    """The loop; what lies at each pixel is kept as the sum of falloffs and that of values."""
    count, channels = windows.shape[0], windows.shape[3]
    mass, total = np.zeros((shape[0], shape[1])), np.zeros((shape[0], shape[1], channels))
    places, shifts = corners.copy(), np.zeros_like(corners)
    for p in range(count):
        _lay(windows[p], falloff, places[p], mass, total, 1.0)
    energies = [_energy(windows, falloff, mass, total, shifts, held, first, stiffness)]
    for _ in range(sweeps):
        moved = False
        for p in range(count):
            _lay(windows[p], falloff, places[p], mass, total, -1.0)
            before = shifts[p].copy()
            least = _cost(windows[p], falloff, places[p], mass, total, np.inf)
            least += stiffness * _spring(p, before, shifts, held, first)
            for y in range(-reach, reach + 1):
                for x in range(-reach, reach + 1):
                    place, shift = corners[p].copy(), before.copy()
                    place[0], place[1], shift[0], shift[1] = place[0] + y, place[1] + x, y, x
                    if not _allowed(place, windows.shape, shape, wraps):
                        continue
                    cost = stiffness * _spring(p, shift, shifts, held, first)
                    cost += _cost(windows[p], falloff, place, mass, total, least - cost)
                    if cost < least * (1 - 1e-6):
                        least, moved = cost, True
                        for axis in range(2):
                            places[p, axis], shifts[p, axis] = place[axis], shift[axis]
            _lay(windows[p], falloff, places[p], mass, total, 1.0)
        energies.append(_energy(windows, falloff, mass, total, shifts, held, first, stiffness))
        if not moved:
            break
    for p in range(count):
        places[p, 0], places[p, 1] = places[p, 0] % shape[0], places[p, 1] % shape[1]
    return energies, places


@jitted
def _allowed(place: Places, size: Any, shape: Places, wraps: Any) -> bool:
    """Whether a window with this first pixel lies on the image."""
    for axis in range(2):
        if not wraps[axis] and (place[axis] < 0 or place[axis] > shape[axis] - size[axis + 1]):
            return False
    return True


@jitted
def _lay(window: Array, falloff: Array, place: Places, mass: Any, total: Any, sign: float) -> None:
    """Add a window to the sums, or take it away."""
    for y in range(falloff.shape[0]):
        row = (place[0] + y) % mass.shape[0]
        for x in range(falloff.shape[1]):
            column, weight = (place[1] + x) % mass.shape[1], sign * falloff[y, x]
            mass[row, column] += weight
            for c in range(window.shape[2]):
                total[row, column, c] += weight * window[y, x, c]


@jitted
def _cost(window: Array, falloff: Array, place: Places, mass: Any, total: Any, enough: float) -> float:
    """What a window adds to the squares about the means, or something above `enough`: g n / (n + g) |z - m|^2."""
    cost = 0.0
    for y in range(falloff.shape[0]):
        row = (place[0] + y) % mass.shape[0]
        for x in range(falloff.shape[1]):
            column = (place[1] + x) % mass.shape[1]
            own, others = falloff[y, x], mass[row, column]
            if others > 1e-9:
                apart = 0.0
                for c in range(window.shape[2]):
                    apart += (window[y, x, c] - total[row, column, c] / others) ** 2
                cost += own * others / (own + others) * apart
        if cost > enough:
            break
    return cost


@jitted
def _spring(p: int, shift: Places, shifts: Places, held: Places, first: Places) -> float:
    """Squared differences to the shifts of the windows that p is held to."""
    length = 0.0
    for k in range(first[p], first[p + 1]):
        length += (shift[0] - shifts[held[k], 0]) ** 2 + (shift[1] - shifts[held[k], 1]) ** 2
    return length


@jitted
def _energy(
    windows: Array, falloff: Array, mass: Any, total: Any, shifts: Places, held: Places, first: Places, stiffness: float
) -> float:
    """E of the module."""
    energy = 0.0
    for p in range(len(windows)):
        energy += stiffness / 2 * _spring(p, shifts[p], shifts, held, first)
        for y in range(falloff.shape[0]):
            for x in range(falloff.shape[1]):
                for c in range(windows.shape[3]):
                    energy += falloff[y, x] * windows[p, y, x, c] ** 2
    for row in range(mass.shape[0]):
        for column in range(mass.shape[1]):
            if mass[row, column] > 1e-9:
                for c in range(total.shape[2]):
                    energy -= total[row, column, c] ** 2 / mass[row, column]
    return energy
