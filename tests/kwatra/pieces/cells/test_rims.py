"""Elements up to their rims, on ground that is wide and plain."""

import numpy as np
from discs import RADIUS, discs
from scipy import ndimage

from kwatra.pieces.cells.rims import SOME, TIP, UNLIKE, plain_ground, tips, with_rims
from kwatra.pieces.seams import Parts

RIM = 2


def rimmed(noise: float) -> tuple[Parts, np.ndarray, np.ndarray]:
    """Discs taken for elements without their rims, which are nearly as dark as the ground; colors, and the truth."""
    image, number = discs(3, 4, noise=noise)
    inner = np.where(ndimage.binary_erosion(number > 0, iterations=RIM), number, 0)
    colors = image.numpy().copy()
    colors[:, (number > 0) & (inner == 0)] = 0.35
    return Parts(inner, inner > 0, (inner > 0).astype(float), 2.0 * RADIUS), colors, number


def alike(found: np.ndarray, truth: np.ndarray) -> bool:
    """Whether elements are the same, however they are numbered, and the ground is 0."""
    pairs = np.unique(np.stack([found.ravel(), truth.ravel()]), axis=1).T.tolist()
    numbers = len(np.unique(found)), len(np.unique(truth))
    return [0, 0] in pairs and numbers == (len(pairs), len(pairs))


def test_rims_are_of_the_elements_beside_them() -> None:
    for noise in (0.0, 0.01):
        parts, colors, truth = rimmed(noise)
        inside = np.ones(truth.shape, bool)
        plain = plain_ground(parts.number, inside)
        assert plain is not None
        assert not (plain & (truth > 0)).any()
        found = with_rims(parts, colors, inside, plain).number
        assert ((found > 0) != (truth > 0)).mean() < 0.002
        assert alike(np.where(truth > 0, found, 0), np.where(found > 0, truth, 0))
        assert np.array_equal(with_rims(parts._replace(number=found), colors, inside, plain).number > 0, found > 0)


def test_ground_that_looks_like_the_rest_of_it_is_none_and_nothing_is_added_outside() -> None:
    parts, colors, truth = rimmed(0.02)
    inside = np.ones(truth.shape, bool)
    inside[:, 40:] = False
    plain = plain_ground(parts.number, inside)
    assert plain is not None
    assert not (plain & ~inside).any()
    found = with_rims(parts, colors, inside, plain).number
    assert np.array_equal(found[:, 40:] > 0, parts.number[:, 40:] > 0)
    near = ndimage.binary_dilation(truth > 0)
    assert not (found > 0)[~near].any()
    quiet = np.where(truth > 0, colors, 0.1 + 0.02 * np.sin(np.arange(colors[0].size)).reshape(truth.shape))
    assert UNLIKE * 0.02 / np.sqrt(2) < 0.15
    assert alike(with_rims(parts, quiet, inside, plain).number[:, :40], truth[:, :40])


def test_what_looks_like_ground_along_an_edge_is_ground_and_so_are_specks() -> None:
    parts, colors, truth = rimmed(0.0)
    inside, wide = np.ones(truth.shape, bool), ndimage.grey_dilation(truth, footprint=np.ones((3, 3)))
    wide[wide > 0] += 1
    wide[1:3, 1:3] = 1  # as dark as the ground
    wide[1:3, 5:7], colors[:, 1:3, 5:7] = wide.max() + 1, 0.9  # bright, but small
    plain = plain_ground(wide, inside)
    assert plain is not None
    found = with_rims(parts._replace(number=wide), colors, inside, plain).number
    assert alike(found, truth)
    none = np.where(truth == 3, -1, wide)
    found = with_rims(parts._replace(number=none), colors, truth != 3, plain & (truth != 3)).number
    assert np.array_equal(found == -1, truth == 3)
    assert len(np.unique(found)) == found.max() + 2


def test_joints_are_no_plain_ground() -> None:
    number = np.kron(np.arange(1, 26).reshape(5, 5), np.ones((16, 16), int))
    inside = np.ones(number.shape, bool)
    joints = (np.indices(number.shape) % 16 >= 12).any(0)  # 4 px wide: 2 from either side
    assert plain_ground(np.where(joints, 0, number), inside) is None
    wide = (np.indices(number.shape) % 16 >= 9).any(0)
    plain = plain_ground(np.where(wide, 0, number), inside)
    assert plain is not None
    assert plain.mean() > SOME
    assert ndimage.distance_transform_edt(wide)[plain].min() >= 3
    assert plain_ground(np.zeros((4, 4), int), np.zeros((4, 4), bool)) is None


def test_tips_are_what_the_border_leaves_and_no_rims_or_specks() -> None:
    parts, colors, truth = rimmed(0.0)
    inside, wanted = np.ones(truth.shape, bool), np.zeros(truth.shape, bool)
    wanted[:2, 24:27] = wanted[-1, :TIP] = True
    inside[20:30, 40:50] = False
    wanted[30:32, 44:47] = True  # at what is not inside
    speck = np.zeros(truth.shape, bool)
    speck[26, 20:24] = speck[0, 60] = True  # inside, and too small
    colors[:, wanted | speck] = 0.6
    plain = plain_ground(parts.number, inside)
    assert plain is not None
    assert np.array_equal(tips(parts.number, colors, inside, plain), wanted & (truth == 0))
    assert not tips(truth, colors, inside & ~wanted, plain)[wanted].any()


def test_colors_count_by_how_much_ground_varies_along_them() -> None:
    parts, colors, truth = rimmed(0.0)
    inside, checks = np.ones(truth.shape, bool), 0.3 * (np.indices(truth.shape).sum(0) % 2)
    colors[:, truth == 0] += checks[truth == 0]  # from dark to brighter than rims
    rim = (truth > 0) & (parts.number == 0)
    plain = plain_ground(parts.number, inside)
    assert plain is not None
    assert (with_rims(parts, colors, inside, plain).number > 0)[rim].mean() < 0.1
    colors[0, rim] -= 0.15  # of another hue
    assert alike(with_rims(parts, colors, inside, plain).number, truth)


def test_elements_that_hang_together_by_what_looks_like_ground_are_told_apart() -> None:
    parts, colors, truth = rimmed(0.0)
    inside, first, second = np.ones(truth.shape, bool), truth == 1, truth == 2
    row, column = np.indices(truth.shape)
    neck = (
        (np.abs(row - row[first | second].mean()) <= 2)
        & (column > column[first].mean())
        & (column < column[second].mean())
    )
    number = np.where(first | second | neck, 1, truth)
    plain = plain_ground(number, inside)
    assert plain is not None
    found = with_rims(parts._replace(number=number), colors, inside, plain).number
    assert len(np.unique(found[first])) == len(np.unique(found[second])) == 1
    assert found[first][0] != found[second][0]
