"""Elements with bays, as the hulls by which they flow."""

import numpy as np
from made import MADE
from scipy import ndimage
from textures import noise

from kwatra import Exemplar
from kwatra.pieces import cells_that_flow, find_cells
from kwatra.pieces.cells.hulls import hulls
from kwatra.pieces.seams import Parts

SIDE, PITCH = 60, 20


def corners() -> np.ndarray:
    """Nine elements, each two bars at a right angle, whose hulls are triangles with a little more; numbered from 1."""
    number = np.zeros((SIDE, SIDE), int)
    for part in range(9):
        y, x = (PITCH * at + 4 for at in divmod(part, 3))
        number[y : y + 12, x : x + 2] = number[y + 10 : y + 12, x : x + 12] = part + 1
    return number


def grown(number: np.ndarray, inside: np.ndarray | None = None) -> np.ndarray:
    """The numbers of what they are grown to."""
    parts = Parts(number, number > 0, (number > 0).astype(float), float(PITCH))
    made = hulls(parts, number >= 0 if inside is None else inside)
    assert made is not None
    return made.number


def test_elements_with_bays_are_grown_to_their_hulls() -> None:
    number, made = corners(), grown(corners())
    assert np.array_equal(made[number > 0], number[number > 0])
    for part in range(9):
        y, x = (PITCH * at + 4 for at in divmod(part, 3))
        row, column = np.indices((12, 12))
        own = made[y : y + 12, x : x + 12] == part + 1
        assert own[column - row <= -1].all()  # the bars' ends are 2 px wide: what is below the line between them
        assert not own[column - row >= 3].any()
        assert np.count_nonzero(made == part + 1) == np.count_nonzero(own)


def test_hulls_take_nothing_that_is_nearer_to_another() -> None:
    number = corners()
    number[26:28, 32:34] = 10  # in the bay of the fifth, next to its hull's long side
    made = grown(number)
    near = np.hypot(*(np.indices(number.shape) - np.array([26.5, 32.5])[:, None, None])) < 2
    assert np.array_equal(made == 10, number == 10)
    assert not (made[near] == 5).any()
    assert (made[30:34, 26:28] == 5).all()


def test_what_the_border_or_a_hole_cuts_stays_as_it_is() -> None:
    number, inside = np.roll(corners(), -4, (0, 1)), np.ones((SIDE, SIDE), bool)
    inside[30:34, 52:] = False
    made = grown(number, inside)
    for part in (1, 2, 3, 4, 7, 6):
        assert np.array_equal(made == part, number == part), part
    for part in (5, 8, 9):
        assert np.count_nonzero(made == part) > 1.4 * np.count_nonzero(number == part), part


def test_elements_without_bays_have_none() -> None:
    number = np.zeros((SIDE, SIDE), int)
    for part in range(9):
        y, x = (PITCH * at + 4 for at in divmod(part, 3))
        number[y : y + 12, x : x + 9] = part + 1
    parts = Parts(number, number > 0, (number > 0).astype(float), float(PITCH))
    assert hulls(parts, number >= 0) is None
    assert hulls(parts._replace(number=np.zeros_like(number)), number >= 0) is None


def test_letters_have_cells_in_flows_alone() -> None:
    for size, seed in ((20, 0), (24, 1)):
        made = MADE["letters"](128, size, seed)
        exemplar = Exemplar.of(made.image)
        assert find_cells(exemplar) is None
        cells = cells_that_flow(exemplar)
        assert cells is not None
        assert cells.loose
        assert cells.sure[cells.whole].mean() > 0.85
        ink = made.numbers.numpy() > 0
        assert cells.element[ink].mean() > 0.9
        assert (cells.number > 0)[ink].mean() > 0.9  # of all but tips that the border leaves
        far = ndimage.distance_transform_edt(~ink) > 0.9 * size
        assert not (cells.number > 0)[far].any()


def test_what_has_cells_or_none_has_the_same_where_it_flows() -> None:
    coins = Exemplar.of(MADE["coins"](128, 24, 0).image)
    assert cells_that_flow(coins) is find_cells(coins) is not None
    for image in (noise(3, 64, 64), MADE["bricks"](128, 32, 1).image):
        assert cells_that_flow(Exemplar.of(image)) is None
