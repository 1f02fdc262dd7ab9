"""Elements made whole where copies of them overlap, or leave room between them."""

import numpy as np
import pytest
import torch
from scipy import ndimage
from scipy.spatial import cKDTree

from kwatra.pieces.cells import Cells, cells_of, copies, fitted, redrawn
from kwatra.pieces.cells.copies import UNDONE, copies_of, copies_that_flow
from kwatra.pieces.seams import Parts

SIDE, PITCH = 96, 16
IMAGE = np.zeros((1, SIDE, SIDE))


def stones() -> Cells:
    """Stones of about PITCH pixels that fill a square of SIDE pixels, two pixels apart."""
    rng = np.random.default_rng(0)
    middles = np.argwhere(np.ones((SIDE // PITCH + 2,) * 2)) * PITCH - PITCH / 2 + rng.uniform(-4, 4, (64, 2))
    pixels = np.stack(np.indices((SIDE, SIDE)), -1).reshape(-1, 2)
    apart, which = cKDTree(middles).query(pixels, k=2)
    number = np.where(apart[:, 1] - apart[:, 0] > 2, which[:, 0] + 1, 0).reshape(SIDE, SIDE)
    numbered = np.unique(number, return_inverse=True)[1].reshape(SIDE, SIDE)
    parts = Parts(numbered, numbered > 0, (numbered > 0).astype(float), float(PITCH))
    cells = cells_of(parts, np.ones((SIDE, SIDE), bool))
    assert cells is not None
    return cells


def halves(down: int) -> torch.Tensor:
    """A map whose right half shows what is elsewhere by so much than its left half goes on."""
    where = torch.stack(torch.meshgrid(torch.arange(80), torch.arange(80), indexing="ij"))
    where[0, :, 40:] += down
    where[1, :, 40:] -= 30
    return where


def shares_seen(where: torch.Tensor, cells: Cells) -> list[float]:
    """How much is seen of each whole element that lies inside of an output, in each place where any of it is."""
    shown, seen = np.where(cells.element, cells.number, 0)[tuple(where.numpy())], []
    for number in np.flatnonzero(cells.whole):
        regions, count = ndimage.label(shown == number, np.ones((3, 3)))
        for region in range(1, count + 1):
            own = np.argwhere(regions == region)
            if own.min() > 0 and own.max() < 79:
                seen.append(len(own) / (cells.element & (cells.number == number)).sum())
    return seen


def parts_seen(where: torch.Tensor, cells: Cells) -> list[float]:
    """Of each whole element that is seen inside of an output, the part of it, however small, that is told by pixels."""
    places, shown = where.numpy(), np.where(cells.element, cells.number, 0)[tuple(where.numpy())]
    seen = []
    for number in np.flatnonzero(cells.whole):
        regions, count = ndimage.label(shown == number, np.ones((3, 3)))
        for region in range(1, count + 1):
            own, told = np.argwhere(regions == region), np.zeros((SIDE, SIDE), bool)
            told[tuple(places[:, regions == region])] = True
            if own.min() > 0 and own.max() < 79:
                element = cells.element & (cells.number == number)
                seen.append(ndimage.binary_dilation(told, np.ones((3, 3)))[element].mean())
    return seen


def test_pixels_continue_each_other_in_one_cell() -> None:
    rng = np.random.default_rng(0)
    number = rng.integers(1, 3, (9, 11))
    where = np.indices(number.shape) + copies.APART * rng.integers(0, 3, (1, 1, 11))
    for axis in range(2):
        found = copies._continued(number, where, axis)
        for i, j in np.ndindex(found.shape):
            y, x = i + (axis == 0), j + (axis == 1)
            off = np.abs(where[:, y, x] - where[:, i, j] - np.eye(2)[axis]).max()
            assert found[i, j] == (number[i, j] == number[y, x] and off <= copies.APART)
    assert found.any()
    assert not found.all()


def test_a_copy_that_is_whole_stays_as_it_is() -> None:
    cells, where = stones(), halves(0)
    where[1, :, 40:] += 30
    assert torch.equal(fitted(where, cells, IMAGE).places, where.double())


def test_elements_that_a_seam_cuts_are_whole_and_the_others_stay() -> None:
    cells, where = stones(), halves(6)
    made = fitted(where, cells, IMAGE).places.round().long()
    before, after = shares_seen(where, cells), shares_seen(made, cells)
    assert sum(share < 0.6 for share in before) > 4
    assert sum(share < 0.6 for share in after) == 0
    assert 1.05 < max(after) < 1.7  # some are stretched
    assert len(after) > 12
    assert torch.equal(made[:, :, :16], where[:, :, :16])
    assert torch.equal(made[:, :, 64:], where[:, :, 64:])
    assert bool(((made >= 0) & (made < SIDE)).all())
    assert torch.equal(fitted(where, cells, IMAGE).places.round().long(), made)


def test_what_is_warped_lies_between_pixels_and_elements_that_have_their_place_on_them() -> None:
    cells, where = stones(), halves(6)
    made, changed, *_ = fitted(where, cells, IMAGE)
    assert torch.equal(changed, (made != where).any(0))
    between = (made != made.round()).any(0)
    assert 0.05 < float(between.float().mean()) < 0.5
    assert not between[:, :16].any()
    off = (made[:, 1:] - made[:, :-1])[:, between[1:] & between[:-1]] - torch.tensor([[1.0], [0.0]])
    assert 0 < float(off.abs().median()) < 0.3  # but for borders of cells


def test_what_is_not_sure_stays() -> None:
    cells, where = stones(), halves(6)
    none = cells._replace(sure=np.zeros_like(cells.sure))
    assert torch.equal(fitted(where, none, IMAGE).places, where.double())


def test_an_output_that_wraps_is_fitted_across_its_border() -> None:
    cells, where = stones(), halves(6)
    made, rolled = (fitted(some, cells, IMAGE, (False, True)).places.round() for some in (where, where.roll(27, 2)))
    assert not torch.equal(made[:, :, :8], where[:, :, :8])  # the halves meet there, too
    assert float((made.roll(27, 2) != rolled).any(0).float().mean()) < 0.01  # but for ties


def test_copies_are_those_of_which_enough_is_seen() -> None:
    cells, where = stones(), halves(6).numpy()
    copies = copies_of(where, cells)
    number = cells.number[tuple(where)]
    for m, (cell, to) in enumerate(zip(copies.laid.cell, copies.laid.to, strict=True)):
        own = copies.number == m
        assert (number[own] == cell).all()
        assert np.array_equal(to[:, :2], np.eye(2))
        assert np.array_equal(where[:, own], np.argwhere(own).T + to[:, 2:])  # one copy, one offset
        start = np.argwhere(cells.number == cell).min(0) - to[:, 2]
        inside = (start > 1).all() and (start + np.ptp(np.argwhere(cells.number == cell), 0) < 77).all()
        assert not inside or own.sum() >= 0.45 * cells.area[cell]
    assert len(copies.laid.cell) > 20
    assert 0 < (copies.number < 0).mean() < 0.3
    assert (number[copies.stays] > 0).all()
    assert not cells.sure[number[copies.stays]].any()


def turned(angle: float, stretched: float) -> torch.Tensor:
    """Places (2, 80, 80) of a picture that is turned about its middle, and stretched along its columns."""
    down, right = torch.meshgrid(torch.arange(80.0) - 40, torch.arange(80.0) - 40, indexing="ij")
    cos, sin = np.cos(angle), np.sin(angle)
    return torch.stack([cos * down - sin * right, sin * down + cos * right]) * torch.tensor([1 / stretched, 1.0]).view(
        2, 1, 1
    ) + torch.tensor([47.3, 48.1]).view(2, 1, 1)


def test_what_is_whole_is_drawn_as_it_was_moved_and_is_turned_back_by_a_part() -> None:
    cells, places = stones(), turned(0.3, 1.1)
    inside = ((places >= 0) & (places <= SIDE - 1)).all(0)
    drawn = redrawn(places, inside, cells)
    assert float((drawn - places).square().sum(0).sqrt()[inside].median()) < 0.8  # .3 of an angle of .3, of a stone
    for axis in (1, 2):
        both = inside & inside.roll(-1, axis - 1)
        before, after = (values.roll(-1, axis) - values for values in (places, drawn))
        upright = (torch.arange(2) == axis - 1).double()
        wanted = before[:, both].median(1).values * (1 - UNDONE) + UNDONE * upright
        assert torch.allclose(after[:, both].double().median(1).values, wanted.double(), atol=0.02)
    assert torch.equal(drawn[:, ~inside], places[:, ~inside])
    assert torch.equal(redrawn(places, inside, cells), drawn)


def test_what_is_upright_stays_where_it_is() -> None:
    cells, places = stones(), turned(0.0, 1.0)
    off = (redrawn(places, torch.ones(80, 80, dtype=torch.bool), cells) - places).square().sum(0).sqrt()
    assert float((off < 0.2).float().mean()) > 0.75  # but for the joints, which are smooth
    assert float(off.median()) < 1e-3


def test_elements_come_to_have_the_room_that_they_need(monkeypatch: pytest.MonkeyPatch) -> None:
    cells, everywhere = stones(), torch.ones(80, 80, dtype=torch.bool)

    def uneven() -> float:
        """By how much the rooms of elements differ from those that they have in the exemplar, in the end."""
        places = halves(6).double()
        for _ in range(12):
            places = redrawn(places, everywhere, cells)
        found = copies_that_flow(places.numpy(), everywhere.numpy(), cells)
        inner = (found.laid.corner > 0).all(1) & (found.laid.corner + found.laid.size < 80).all(1)
        shown = np.bincount(found.number[found.number >= 0], minlength=len(inner))[inner]
        return float(np.abs(np.log(shown / cells.area[found.laid.cell][inner])).mean())

    pushed = uneven()
    monkeypatch.setattr(copies, "PUSH", 0.0)
    assert pushed < 0.9 * uneven()


def test_elements_that_overlap_are_drawn_whole_and_move_a_little_if_they_do() -> None:
    cells, places = stones(), halves(6).double()
    everywhere, near = torch.ones(80, 80, dtype=torch.bool), torch.tensor([0.2, -0.1]).double().view(2, 1, 1)
    drawn, moved = redrawn(places, everywhere, cells), redrawn(places + near, everywhere, cells)
    before, after = (parts_seen(at.round().long().clamp(0, SIDE - 1), cells) for at in (places, drawn))
    assert sum(part < 0.9 for part in before) > 4
    assert sum(part < 0.9 for part in after) == 0
    assert len(after) > 12
    off = (moved - drawn - near).square().sum(0).sqrt()
    assert float(off.median()) < 0.1
    assert float((off > 1).float().mean()) < 0.05


def test_of_elements_that_a_mask_hides_what_is_seen_stays() -> None:
    cells, places = stones(), turned(0.0, 1.0)
    inside = torch.zeros(80, 80, dtype=torch.bool)
    inside[:, :37] = True
    drawn = redrawn(places, inside, cells)
    off = (drawn - places).square().sum(0).sqrt()
    assert float((off[4:-4, 30:37] < 0.5).float().mean()) > 0.9
    assert torch.equal(drawn[:, :, 37:], places[:, :, 37:])
