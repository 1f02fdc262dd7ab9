"""Loose elements drawn on ground as it was laid, and cleared of others."""

import numpy as np
import torch
from discs import RADIUS, discs
from scipy import ndimage

from kwatra import Exemplar
from kwatra.pieces.cells import Cells, find_cells, fitted, fitting, redrawn
from kwatra.pieces.cells.clearing import RIM, cleared, seen_of
from kwatra.pieces.cells.copies import copies_of, copies_that_flow
from kwatra.pieces.cells.laid import LONGEST, turned


def woven(rows: int, columns: int, border: int = 0) -> tuple[Exemplar, np.ndarray, Cells]:
    """Discs on checks of two pixels, of which a border is taken away, and their cells."""
    image, number = discs(rows, columns, seed=1)
    checks = np.indices(number.shape).sum(0) // 2 % 2
    image = torch.where(torch.from_numpy(number > 0), image, torch.from_numpy(0.1 + 0.05 * checks).float())
    inner = slice(border, -border or None)
    exemplar, number = Exemplar.of(image[:, inner, inner].contiguous()), number[inner, inner]
    cells = find_cells(exemplar)
    assert cells is not None
    assert cells.loose
    return exemplar, number, cells


def upright(height: int, width: int) -> torch.Tensor:
    """The places of an output that shows an exemplar as it is."""
    return torch.stack(torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij"))


def test_an_element_is_seen_with_a_rim_of_its_ground_where_it_is_written() -> None:
    _, number, cells = woven(3, 4)
    written = np.zeros(number.shape, bool)
    written[:, :60] = True
    places = np.indices(number.shape).astype(float)
    seen = seen_of(places, written, cells)
    assert not seen[~written].any()
    away = np.abs(np.argwhere(written & (number > 0))[:, None] - np.argwhere(written)[None]).sum(-1).min(0)
    assert np.array_equal(seen[written], away <= RIM)


def test_what_is_seen_of_an_element_that_nobody_wants_is_filled_with_ground_that_goes_on() -> None:
    exemplar, number, cells = woven(4, 4)
    where, image = np.indices(number.shape), exemplar.canvas.numpy()
    stays = ~np.isin(number, (6, 11))
    made = cleared(where, where.astype(float), np.zeros(number.shape, bool), stays, cells, image)
    assert np.array_equal(made[:, stays], where[:, stays])
    there = tuple(made[:, ~stays].astype(int))
    assert not (number[there] > 0).any()
    bright = np.argwhere(~stays).sum(1) // 2 % 2 == 1
    assert ((image[0][there] > 0.125) == bright).mean() > 0.9  # of checks half would agree by chance


def test_elements_are_drawn_on_ground_as_it_was_laid() -> None:
    exemplar, number, cells = woven(3, 5)
    where = upright(78, 130)
    where = torch.stack([where[0], torch.where(where[1] < 52, where[1], where[1] - 15)])
    made = fitted(where, cells, exemplar.canvas.numpy()).places.round().long()
    before, after = (number[tuple(at.numpy())] > 0 for at in (where, made))
    far = ~ndimage.binary_dilation(before | after, np.ones((3, 3)), iterations=RIM)
    assert far.mean() > 0.1
    assert torch.equal(made[:, far], where[:, far])
    assert not torch.equal(made, where)


def test_the_tip_of_an_element_at_the_border_is_never_shown() -> None:
    exemplar, number, cells = woven(5, 5, border=2 + 26 - 13 + RADIUS - 1)
    height, width = number.shape
    tip = (number > 0) & (cells.number == 0)
    assert tip.any()
    assert tip.sum() < 0.02 * number.size
    where = upright(height, width)
    where = torch.stack([where[0].roll(height // 2, 0), where[1]])  # the border lies in the middle
    made = fitted(where, cells, exemplar.canvas.numpy()).places.round().long()
    assert tip[tuple(where[:, 10:-10].numpy())].any()
    assert not tip[tuple(made.numpy())].any()


def test_a_small_part_that_the_border_leaves_of_a_loose_element_does_not_stay() -> None:
    _, _, cells = woven(4, 4, border=20)
    where, cut = np.indices(cells.number.shape), ~cells.whole
    assert np.count_nonzero(cut) > 1
    for size, stays in ((0.9, False), (1.1, True)):  # what is larger is several that hang together
        area = np.where(cut, round(size * cells.usual), cells.area)
        unsure = cells._replace(sure=cells.sure & cells.whole, area=area)
        assert copies_of(where, unsure).stays.any() == stays
        assert copies_of(where, unsure._replace(gaps=(1.0, 4.0))).stays.any()


def test_of_what_flows_nothing_stays_that_the_border_cuts_of_loose_elements() -> None:
    """It would be drawn out without end."""
    _, _, cells = woven(4, 4, border=20)
    where, everywhere = np.indices(cells.number.shape).astype(float), np.ones(cells.number.shape, bool)
    large = cells._replace(area=np.where(cells.whole, cells.area, round(1.1 * cells.usual)))
    for unsure, stays in ((~cells.whole, False), (cells.whole, True)):
        flowing = large._replace(sure=cells.sure & ~unsure)
        assert copies_that_flow(where, everywhere, flowing).stays.any() == stays
        assert copies_that_flow(where, everywhere, flowing._replace(gaps=(1.0, 4.0))).stays.any()
        assert copies_of(where.astype(int), flowing).stays.any()


def test_ground_around_loose_elements_flows_on_while_they_stay_round() -> None:
    _, number, cells = woven(4, 4)
    places = upright(104, 104).double()
    places[1] += 0.4 * (places[0] - 52)  # sheared
    inside = ((places >= 0) & (places <= 103)).all(0)
    made = redrawn(places, inside, cells)
    before, after = (number[tuple(at.round().long().clamp(0, 103).numpy())] > 0 for at in (places, made))
    still = torch.from_numpy(~(before | after)) & (made == places).all(0)
    assert float(still.float().mean()) > 0.3
    copies = copies_that_flow(places.numpy(), inside.numpy(), cells)
    assert np.abs(copies.laid.to[:, 1, 0]).max() < 0.25  # of .4 half is undone
    assert torch.equal(made[:, ~inside], places[:, ~inside])


def test_what_would_be_drawn_as_nearly_nothing_is_only_moved() -> None:
    pixels = np.indices((12, 12)).astype(float)
    copy = np.zeros((12, 12), int)
    half_turn = 20 - pixels + 0.01 * pixels[::-1]
    assert np.array_equal(turned(half_turn, copy, 1, 0.5)[0, :, :2], np.eye(2))
    found = turned(half_turn, copy, 1, 0.0)[0, :, :2]
    assert np.allclose(found, [[-1, 0.01], [0.01, -1]], atol=1e-3)
    longer = np.stack([(LONGEST + 1) * pixels[0], pixels[1] / LONGEST])
    assert np.array_equal(turned(longer, copy, 1, 0.0)[0, :, :2], np.eye(2))


def test_of_elements_that_lack_room_the_one_that_lacks_most_gives_way() -> None:
    _, number, cells = woven(3, 5)
    copies = copies_of(np.indices(number.shape), cells)
    share = fitting._divided(copies, cells, cells.shapes.away).share
    assert not fitting._crowded(cells, copies, share).any()
    of_disc = [np.bincount(copies.number[number == disc]).argmax() for disc in range(1, 16)]
    for disc, lacking in ((7, 0.5), (8, 0.4), (15, 0.6), (13, 0.2)):  # 8 lies between 7 and 9
        own = np.argwhere(number == disc)
        share[tuple(own[: round(lacking * len(own))].T)] = -1
    found = np.flatnonzero(fitting._crowded(cells, copies, share)).tolist()
    assert sorted(found) == sorted([of_disc[6], of_disc[14]])


def test_copies_without_some_are_numbered_anew() -> None:
    _, _, cells = woven(3, 4)
    copies = copies_of(np.indices(cells.number.shape), cells)
    some = np.isin(np.arange(len(copies.shown)), (1, 4))
    left = copies.without(some)
    assert np.array_equal(left.laid.cell, copies.laid.cell[~some])
    assert np.array_equal(left.elements, copies.elements[~some])
    kept = left.number >= 0
    assert np.array_equal(left.laid.cell[left.number[kept]], copies.laid.cell[copies.number[kept]])
    assert np.array_equal(~kept, (copies.number < 0) | np.isin(copies.number, (1, 4)))
