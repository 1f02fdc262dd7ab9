"""The cells of an exemplar: elements and the ground around them."""

import numpy as np
import torch
from discs import discs
from scipy import ndimage
from skimage import data
from textures import noise

from kwatra import Exemplar
from kwatra.pieces.cells import Cells, cells_of, find_cells
from kwatra.pieces.cells.loops import window
from kwatra.pieces.seams import Parts, hidden_seams

PITCH = 12


def squares(rows: int, columns: int, gap: int = 2, pitch: int = PITCH) -> Parts:
    """Squares on a lattice, with ground of a gap's width around each; the first row lies on the border."""
    number = np.zeros((rows * pitch, columns * pitch), int)
    for row in range(rows):
        for column in range(columns):
            y, x = row * pitch, column * pitch
            number[y + gap : y + pitch - gap, x + gap : x + pitch - gap] = row * columns + column + 1
    return Parts(number, number > 0, (number > 0).astype(float), float(pitch))


def found(parts: Parts) -> Cells:
    """Their cells, of which there have to be some."""
    cells = cells_of(parts, parts.number >= 0)
    assert cells is not None
    return cells


def test_cells_are_elements_and_the_ground_nearer_to_them_than_to_others() -> None:
    cells, number = found(squares(4, 5)), squares(4, 5).number
    truth = np.arange(4 * PITCH)[:, None] // PITCH * 5 + np.arange(5 * PITCH) // PITCH + 1
    assert np.array_equal(cells.number, truth)
    assert np.array_equal(cells.element, number > 0)
    assert (cells.area[1:] == PITCH**2).all()
    assert cells.usual == PITCH**2
    assert cells.whole[1:].all()
    assert cells.sure[1:].all()
    assert not cells.sure[0]
    assert not cells.loose
    assert cells.reach == PITCH // 2
    assert 1.8 < cells.gaps[0] <= 2 < cells.gaps[1] < 2.9  # wider along rays that meet them obliquely


def test_windows_tell_how_far_it_is_to_the_border_of_a_cell() -> None:
    cells = found(squares(4, 5))
    away, soft = (window(cells.shapes.windows, values, 7) for values in (cells.shapes.away, cells.shapes.soft))
    half = PITCH // 2
    assert away.shape == (2 * PITCH, 2 * PITCH)
    assert tuple(cells.shapes.first[7]) == (PITCH - half, PITCH - half)
    own = np.zeros(away.shape, bool)
    own[half:-half, half:-half] = True
    truth = np.where(own, 0.5 - ndimage.distance_transform_edt(own), ndimage.distance_transform_edt(~own) - 0.5)
    assert np.allclose(away, truth)
    assert np.allclose(soft, away, atol=1)
    assert not np.array_equal(soft, away)
    element = window(cells.shapes.windows, cells.shapes.element, 7)
    assert np.array_equal(np.argwhere(element)[[0, -1]], [[half + 2] * 2, [half + PITCH - 3] * 2])


def test_what_is_larger_or_not_compact_is_not_sure_and_where_most_is_not_there_are_no_cells() -> None:
    parts = squares(5, 5)
    joined = parts.number.copy()
    joined[2:10, 2:22] = 1  # two squares that were not told apart
    joined[joined == 25] = 2
    cells = found(parts._replace(number=joined))
    assert not cells.sure[1]
    assert cells.sure[3:25].all()
    hollow = parts.number.copy()
    hollow[4::PITCH], hollow[5::PITCH], hollow[6::PITCH], hollow[7::PITCH] = 0, 0, 0, 0
    hollow[:, 2::PITCH], hollow[:, 3::PITCH] = (
        parts.number[:, 2::PITCH],
        parts.number[:, 3::PITCH],
    )  # of the form of a C
    assert cells_of(parts._replace(number=hollow), parts.number >= 0) is None
    assert cells_of(squares(1, 2), np.ones((PITCH, 2 * PITCH), bool)) is None
    assert cells_of(squares(5, 5, pitch=9), np.ones((45, 45), bool)) is None  # too small


def test_discs_have_cells_and_print_has_none() -> None:
    image, number = discs(5, 5)
    cells = find_cells(Exemplar.of(image))
    assert cells is not None
    assert cells.sure[1:].all()
    assert len(cells.sure) == 26
    assert cells.element[number > 0].all()
    pairs = np.unique(np.stack([number[number > 0], cells.number[number > 0]]), axis=1)
    assert pairs.shape[1] == len(np.unique(pairs[1])) == 25  # each cell holds one disc
    assert cells.gaps[0] == 1.0
    assert cells.loose
    page = Exemplar.of(torch.from_numpy(data.page()[:, :160]).float()[None] / 255)
    assert hidden_seams(page) is not None
    assert find_cells(page) is None
    assert find_cells(Exemplar.of(noise(3, 64, 64))) is None


def test_loose_elements_may_be_of_many_sizes() -> None:
    """Of those that fill the plane what is much larger than usual is two that were not told apart."""
    side, generator = 140, np.random.default_rng(3)
    y, x = np.mgrid[:side, :side]
    image, kept = np.full((side, side), 0.9), list[tuple[float, float, int]]()
    for radius in (15, 5):
        for _ in range(400):
            row, column = generator.uniform(0, side, 2)
            if all(np.hypot(row - r, column - c) > radius + other + 4 for r, c, other in kept):
                kept.append((row, column, radius))
                image[np.hypot(y - row, x - column) < radius] = 0.2
    cells = find_cells(Exemplar.of(torch.from_numpy(image).float()[None]))
    assert cells is not None
    assert cells.loose
    assert cells.sure[cells.whole].all()
    assert cells.area[cells.whole].max() > 1.6 * cells.usual
