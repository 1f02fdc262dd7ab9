"""Elements that thin lines part."""

import numpy as np
import pytest
import torch
from bench_elements import cut_elements, places_of
from made import MADE
from scipy import ndimage

from kwatra import Exemplar
from kwatra.elements import find_ground
from kwatra.elements.lines import line_strength, nets_of_lines
from kwatra.elements.splits import Ground, Picture
from kwatra.pieces import find_cells
from synth import synthesize


def net_in(image: torch.Tensor) -> Ground | None:
    """The net of lines of a picture."""
    return next(nets_of_lines(Picture(Exemplar.of(image))), None)


def shared(net: np.ndarray, truth: np.ndarray) -> float:
    """The share of two nets' pixels that lie within two pixels of the other (F1)."""
    right, found = (
        (ndimage.distance_transform_edt(~one)[other] <= 2).mean() for one, other in ((truth, net), (net, truth))
    )
    return float(2 * right * found / (right + found))


def lined(*lines: tuple[slice, slice], side: int = 60, grain: float = 0.0) -> np.ndarray:
    """Gray, .2 darker along lines."""
    bright = np.full((side, side), 0.6)
    for line in lines:
        bright[line] = 0.4
    return bright + grain * np.random.default_rng(0).normal(size=bright.shape)


DOWN = np.s_[:, 29:32]


def test_a_line_is_as_strong_as_what_it_is_darker_by() -> None:
    dark, light = line_strength(lined(DOWN))
    assert dark[:, 30] == pytest.approx(dark[0, 30])
    assert 0.6 * 0.2 < dark[30, 30] < 0.2  # of three pixels, smoothed by 1.6
    assert (dark.argmax(1) == 30).all()
    assert dark[:, np.abs(np.arange(60) - 30) > 6].max() < 0.01
    assert light[:, 30].max() < 1e-9


def test_an_edge_is_no_line() -> None:
    dark, light = line_strength(np.where(np.arange(60) < 30, 0.2, 0.8) * np.ones((60, 1)))
    assert max(dark.max(), light.max()) < 0.02


def test_lines_that_are_lighter_are_those_of_the_negative() -> None:
    bright = lined(DOWN, np.s_[15:18], grain=0.05)
    assert np.allclose(line_strength(bright), line_strength(1 - bright)[::-1], atol=1e-12)


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_a_turned_picture_has_turned_lines(turns: int) -> None:
    bright = lined(DOWN, np.s_[40:43, :30], grain=0.05)
    assert np.allclose(
        line_strength(np.rot90(bright, turns)), np.rot90(line_strength(bright), turns, (1, 2)), atol=1e-6
    )


def test_lines_of_any_slope_are_as_strong() -> None:
    down, right = np.indices((81, 81)) - 40
    strong = []
    for angle in np.linspace(0, np.pi, 16, endpoint=False):
        away = np.abs(np.cos(angle) * down + np.sin(angle) * right)
        strong.append(line_strength(0.6 - 0.2 * np.clip(2 - away, 0, 1))[0][40, 40])
    assert min(strong) > 0.8 * max(strong)


def test_a_line_stands_out_of_grain_that_is_as_strong_as_it() -> None:
    strength = line_strength(lined(DOWN, side=120, grain=0.2))[0]
    off = strength[:, np.abs(np.arange(120) - 30) > 8]
    assert np.median(strength[:, 30]) > np.quantile(off, 0.99)


@pytest.mark.parametrize("size", [26, 40])
@pytest.mark.parametrize("light", [False, True])
def test_stones_of_one_color_are_parted_by_the_lines_between_them(size: int, light: bool) -> None:
    made = MADE["granite"](128 if size == 26 else 192, size, 1)
    found = find_ground(Exemplar.of(1 - made.image if light else made.image))
    assert found.hides == 1
    assert 0.8 * size < found.size < 1.1 * size
    assert shared(found.depth == 0, made.numbers.numpy() == 0) > 0.92


def test_whole_stones_are_laid() -> None:
    """.43 of them are cut where the net is not found."""
    made = MADE["granite"](128, 26, 2)
    where = synthesize(made.image, (160, 160), seed=0).take(places_of(made.image))
    assert cut_elements(made.numbers.numpy(), where)["cut"] < 0.15


def test_a_hole_in_a_picture_is_no_line() -> None:
    image, opaque = MADE["granite"](128, 26, 2).image, torch.ones(128, 128, dtype=torch.bool)
    opaque[50:80, 40:44] = False
    whole, found = (next(nets_of_lines(Picture(Exemplar.of(image, masks=[mask])))) for mask in (None, opaque))
    near = ndimage.binary_dilation(~opaque.numpy(), iterations=4)
    assert shared((found.depth == 0)[~near].reshape(1, -1), (whole.depth == 0)[~near].reshape(1, -1)) > 0.95
    assert (found.depth[near] == 0).mean() < 1.5 * (whole.depth[near] == 0).mean()


def noise(smooth: float) -> torch.Tensor:
    """Gray noise, smoothed by so many pixels."""
    values = ndimage.gaussian_filter(np.random.default_rng(1).normal(size=(128, 128)), smooth)
    return torch.from_numpy(0.5 + 0.15 * values / values.std()).float().clamp(0, 1).expand(3, -1, -1)


@pytest.mark.parametrize("smooth", [0.0, 1.0, 3.0])
def test_noise_has_no_net(smooth: float) -> None:
    assert net_in(noise(smooth)) is None


def test_lines_that_part_nothing_are_no_net() -> None:
    """A grid has one; bars that end before they meet another have none."""
    grid = lined(
        *(np.s_[:, at : at + 3] for at in range(15, 128, 30)),
        *(np.s_[at : at + 3] for at in range(15, 128, 30)),
        side=128,
    )
    bars = lined(*(np.s_[20:108, at : at + 3] for at in range(15, 128, 30)), side=128)
    assert net_in(torch.from_numpy(grid).float()[None]) is not None
    assert net_in(torch.from_numpy(bars).float()[None]) is None


@pytest.mark.parametrize(("side", "size", "share"), [(96, 26, 0.1), (96, 38, 0.2)])
def test_bricks_are_parted_by_joints_with_gaps(side: int, size: int, share: float) -> None:
    """Where joints are open bricks grow together, if joints are told pixel by pixel."""
    made, rng = MADE["bricks"](side, size, 3), np.random.default_rng(103)
    soft = ndimage.gaussian_filter(rng.normal(size=(side, side)), 2)
    image, joints = made.image.clone(), made.numbers == 0
    gaps, bricks = joints & torch.from_numpy(soft < np.quantile(soft, share)), image[:, ~joints]
    image[:, gaps] = bricks[:, rng.integers(0, bricks.shape[1], int(gaps.sum()))]
    net = net_in(image)
    assert net is not None
    assert 0.8 * size < net.size < 1.1 * size


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_lines_that_wander_are_no_net(seed: int) -> None:
    """What contours of smooth noise leave is of all sizes."""
    soft = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=(168, 168)), 8)
    away = np.abs(soft) / np.hypot(*np.gradient(soft))
    image = torch.from_numpy(0.7 - 0.4 * np.exp(-((away / 1.5) ** 2))).float()[None, 20:-20, 20:-20]
    assert net_in(image) is None


def test_lines_of_many_colors_are_no_net() -> None:
    """What is beside a seam along them would be seen to change."""
    made = MADE["granite"](128, 26, 2)
    hues = torch.tensor(ndimage.gaussian_filter(np.random.default_rng(0).normal(size=(3, 128, 128)), (0, 5, 5))).float()
    hues = 0.25 * (hues - hues.mean(0)) / hues.std()  # of one brightness
    assert net_in(made.image) is not None
    assert net_in((made.image + hues * torch.from_numpy(made.numbers.numpy() == 0)).clamp(0, 1)) is None


@pytest.mark.parametrize("across", [30, 40, 60])
def test_whether_parts_are_long_is_told(across: int) -> None:
    lines = [
        *(np.s_[at : at + 3] for at in range(15, 128, 30)),
        *(np.s_[:, at : at + 3] for at in range(15, 128, across)),
    ]
    found = net_in(torch.from_numpy(lined(*lines, side=128, grain=0.02)).float()[None])
    assert found is not None
    assert found.long == (across == 60)


@pytest.mark.parametrize("size", [20, 26, 30, 36, 44])
def test_bricks_are_told_by_their_mortar_wherever_the_picture_ends(size: int) -> None:
    """Of some sizes mortar lies along the picture's border, where it parts nothing."""
    made = MADE["bricks"](128, size, 1)
    found = find_ground(Exemplar.of(made.image))
    assert (found.hides, found.long) == (1, True)
    assert 0.9 * size < found.size < 1.1 * size
    net = (found.depth == 0)[6:-6, 6:-6]
    assert shared(net, (made.numbers.numpy() == 0)[6:-6, 6:-6]) > 0.9


def test_whole_bricks_are_laid() -> None:
    """.58 of them are cut where the net is not found."""
    made = MADE["bricks"](128, 36, 1)
    where = synthesize(made.image, (160, 160), seed=0).take(places_of(made.image))
    assert cut_elements(made.numbers.numpy(), where)["cut"] < 0.15


def test_bricks_have_no_cells() -> None:
    """Moved to meet they would lose their straight sides."""
    assert find_cells(Exemplar.of(MADE["granite"](128, 32, 1).image)) is not None
    assert find_cells(Exemplar.of(MADE["bricks"](128, 32, 1).image)) is None


@pytest.mark.parametrize("shape", [(2, 2), (5, 5), (8, 8), (3, 40), (12, 12), (20, 9)])
def test_small_pictures_have_no_net(shape: tuple[int, int]) -> None:
    assert net_in(torch.rand(3, *shape, generator=torch.Generator().manual_seed(0))) is None


def test_a_flat_picture_has_no_net() -> None:
    assert net_in(torch.full((3, 64, 64), 0.4)) is None
