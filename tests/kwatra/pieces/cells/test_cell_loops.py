"""Loops over cells, beside what is known or counted one by one."""

import numpy as np
import pytest
from scipy import ndimage

from kwatra.pieces.cells.loops import count_inside, divide, move, window
from kwatra.pieces.cells.rays import seen_from_middle, warp
from kwatra.pieces.cells.shapes import Shapes

SIDE, RAYS, WHOLE = 61, 128, np.ones(2, bool)


def laid(first: list[list[int]], push: float = 0.0) -> tuple[np.ndarray, ...]:
    """Copies of it, moved by whole pixels, whose windows begin there; the first is pushed."""
    corner = np.array(first)
    to = np.tile(np.eye(2, 3), (len(first), 1, 1))
    to[:, :, 2] = np.array([100, 200]) - corner
    pushes = np.array([push] + [0.0] * (len(first) - 1))
    return np.ones(len(first), int), to, corner, np.full((len(first), 2), SIDE), pushes


def disc(radius: float, element: float, hole: float = 0.0) -> Shapes:
    """One cell, a disc of some radius, with an element of a smaller one in it, which may have a hole."""
    apart = np.hypot(*(np.indices((SIDE, SIDE)) - SIDE // 2))
    away = (apart - radius).astype(np.float32)
    inner = ((apart <= element) & (apart >= hole)).ravel()
    first = np.array([[0, 0], [100, 200]])
    return Shapes(first, np.array([[0, 0], [SIDE, SIDE]]), np.zeros(2, int), away.ravel(), away.ravel(), inner)


@pytest.mark.parametrize(("hole", "share"), [(0.0, 1.0), (3.0, 0.0)])
def test_of_a_disc_all_is_seen_from_its_middle_and_of_a_ring_nothing(hole: float, share: float) -> None:
    seen, gaps = np.empty(2), np.empty((2, RAYS))
    shapes = disc(10, 7.5, hole)
    seen_from_middle(shapes.windows, shapes.away, shapes.element, RAYS, seen, gaps)
    assert seen[1] == pytest.approx(share, abs=0.05)
    if hole == 0:
        assert np.allclose(gaps[1], 2.5, atol=0.4)


@pytest.mark.parametrize("push", [0.0, 3.0])
def test_each_pixel_goes_to_the_copy_it_is_deepest_in(push: float) -> None:
    shapes, first = disc(10, 8), np.array([[-20, -5], [-18, 9]])
    best, second, owner = np.empty((30, 50), np.float32), np.empty((30, 50), np.float32), np.empty((30, 50), np.int64)
    divide(shapes.windows, shapes.away, laid(first.tolist(), push), best, second, owner)
    middles = first + SIDE // 2
    aways = np.stack([np.hypot(*(np.indices((30, 50)) - m[:, None, None])) - 10 for m in middles])
    for m, (down, right) in enumerate(first):  # nowhere else is a copy seen
        seen = np.zeros((30, 50), bool)
        seen[max(down, 0) : down + SIDE, max(right, 0) : right + SIDE] = True
        aways[m][~seen] = np.inf
    far = aways - np.array([push, 0])[:, None, None]
    assert np.allclose(best, far.min(0), atol=1e-4)
    assert np.allclose(second, far.max(0), atol=1e-4)
    assert (owner == far.argmin(0))[np.abs(far[0] - far[1]) > 1e-4].all()
    counts, known = np.zeros((2, 3), np.int64), np.ones((30, 50), bool)
    known[:, 30:] = False
    count_inside(shapes.windows, shapes.away, shapes.element, laid(first.tolist()), known, counts)
    assert (counts[:, 0] == (shapes.away < 0).sum()).all()
    assert np.array_equal(counts[:, 1], ((aways < 0) & known).sum((1, 2)))
    assert np.array_equal(counts[:, 2], ((aways <= -2) & known).sum((1, 2)))


def test_an_element_moves_to_its_share() -> None:
    shapes, owner = disc(10, 8), np.full((60, 80), -1)
    owner[12:32, 30:50] = 0
    copies = laid([[22 - SIDE // 2 + 3, 40 - SIDE // 2 - 5]])
    stays = tuple(part.copy() for part in copies)
    move(shapes.windows, shapes.element, copies, 8, np.array([True]), owner)
    own = np.hypot(*(np.indices(owner.shape) - (copies[2][0] + SIDE // 2)[:, None, None])) <= 8
    assert (owner[own] == 0).all()
    assert np.array_equal(copies[1][0] @ [*copies[2][0], 1], [100, 200])
    move(shapes.windows, shapes.element, stays, 8, np.array([False]), owner)
    assert np.array_equal(stays[2], [[22 - SIDE // 2 + 3, 40 - SIDE // 2 - 5]])


@pytest.mark.parametrize("first", [[4, 9], [-30, 25], [20, 50]])
def test_of_all_places_in_reach_an_element_takes_the_nearest_with_most_of_its_own(first: list[int]) -> None:
    rng, shapes = np.random.default_rng(first[1]), disc(10, 24, 4)
    ragged = shapes._replace(element=shapes.element & (rng.random(SIDE * SIDE) < 0.6))
    owner, copies = rng.integers(-1, 2, (40, 70)), laid([first])
    owner[8:30, 20:44] = 0
    around, shown = np.pad(owner == 0, SIDE + 9, constant_values=True), ragged.element.reshape(SIDE, SIDE)
    counts = {}
    for down in range(-5, 6):
        for right in range(-5, 6):
            top, left = first[0] + down + SIDE + 9, first[1] + right + SIDE + 9
            counts[down, right] = (around[top : top + SIDE, left : left + SIDE] & shown).sum()
    best = min(counts, key=lambda way: (-counts[way], way[0] ** 2 + way[1] ** 2, way))
    move(ragged.windows, ragged.element, copies, 5, np.array([True]), owner)
    assert (copies[2][0] - first).tolist() == list(best)


@pytest.mark.parametrize("radius", [7.0, 10.0, 13.0])
def test_a_share_shows_the_whole_cell_and_an_element_keeps_its_gap(radius: float) -> None:
    shapes, shape = disc(10, 8), (50, 50)
    apart = np.hypot(*(np.indices(shape) - 25))
    best, owner = (apart - radius).astype(np.float32), np.where(apart < radius, 0, -1)
    where, values = np.full((2, *shape), -1.0), (shapes.windows, shapes.away, shapes.element, WHOLE)
    gaps, written = (2.0, 2.0), owner == 0
    warp(*values, laid([[25 - SIDE // 2] * 2]), RAYS, 1.5, gaps, best, -best, owner, written, where)
    where = np.rint(where).astype(int)
    assert (where[:, ~written] == -1).all()
    away = np.hypot(where[0] - 100 - SIDE // 2, where[1] - 200 - SIDE // 2)
    assert away[written].max() < 10
    assert np.corrcoef(apart[written], away[written])[0, 1] > 0.98
    assert np.median(away[(apart > radius - 1) & written]) > 8.5  # the ground at its border
    rim = np.abs(apart - (radius - 2)) < 0.7
    assert np.median(away[rim]) == pytest.approx(8, abs=1.1)  # of the element, as far from the border as it was
    if radius == 10:
        assert np.abs(away - apart)[written].max() <= 1
    inside = window(shapes.windows, shapes.away, 1) < 0
    shown = np.zeros((SIDE, SIDE), bool)
    shown[tuple(where[:, written] - np.array([[100], [200]]))] = True
    assert ndimage.binary_dilation(shown, np.ones((3, 3)))[inside].mean() > 0.97  # nothing of it is left out


def test_ground_that_a_cell_lacks_on_one_side_is_taken_from_beside() -> None:
    """An element that touches another in the exemplar has no rim drawn out where there is room around it."""
    shapes, shape = disc(10, 8), (50, 50)
    right = np.indices((SIDE, SIDE))[1] - SIDE // 2
    away = np.maximum(shapes.away.reshape(SIDE, SIDE), right - 7.5).astype(np.float32).ravel()
    apart = np.hypot(*(np.indices(shape) - 25))
    best, owner = (apart - 13).astype(np.float32), np.where(apart < 13, 0, -1)
    where, values = np.full((2, *shape), -1.0), (shapes.windows, away, shapes.element, WHOLE)
    warp(*values, laid([[25 - SIDE // 2] * 2]), RAYS, 1.5, (1.0, np.inf), best, -best, owner, owner == 0, where)
    written = where[:, owner == 0] - np.array([[100], [200]])
    at = np.rint(written).astype(int)
    assert (away.reshape(SIDE, SIDE)[tuple(at)] < 0.5).all()
    element = shapes.element.reshape(SIDE, SIDE)[tuple(at)]
    assert element[apart[owner == 0] < 7].all()
    assert element[apart[owner == 0] > 9].mean() < 0.03  # it is loose, and keeps its size


@pytest.mark.parametrize("whole", [True, False])
def test_only_an_element_that_the_border_cuts_is_squeezed_for_ground_on_that_side(whole: bool) -> None:
    shapes, shape = disc(10, 8), (50, 50)
    right = np.indices((SIDE, SIDE))[1] - SIDE // 2
    away = np.maximum(shapes.away.reshape(SIDE, SIDE), right - 6.5).astype(np.float32).ravel()
    down, across = np.indices(shape) - 25
    best = np.maximum(np.hypot(down, across) - 10, across - 6.5).astype(np.float32)
    owner, where = np.where(best < 0, 0, -1), np.full((2, *shape), -1.0)
    values = shapes.windows, away, shapes.element, np.array([True, whole])
    warp(*values, laid([[25 - SIDE // 2] * 2]), RAYS, 1.5, (2.0, 2.5), best, -best, owner, owner == 0, where)
    at = np.rint(where - np.array([100, 200])[:, None, None]).astype(int)
    shown = shapes.element.reshape(SIDE, SIDE)[tuple(at.clip(0))]
    on_the_cut, beside = (np.abs(down) <= 2) & (across == 6), (np.abs(down) <= 2) & (across == -9)
    assert (shown[on_the_cut] == whole).all()
    assert not shown[beside].any()
    assert shown[np.hypot(down, across) < 4].all()
