"""The benchmark of cut elements, shrunk, and what it counts as cut."""

import json
import math
from pathlib import Path

import bench_elements
import numpy as np
import pytest
from bench_elements import cut_elements
from made import MADE
from scipy import ndimage


@pytest.fixture
def board() -> np.ndarray:
    """Sixteen elements of 8x8 pixels, 4 pixels of ground between them and 2 around them."""
    cell = np.pad(np.ones((8, 8), dtype=np.int64), 2)
    return np.kron(np.arange(1, 17).reshape(4, 4), cell)


def places(numbers: np.ndarray) -> np.ndarray:
    return np.arange(numbers.size).reshape(numbers.shape)


def test_nothing_is_cut_in_the_exemplar_itself(board: np.ndarray) -> None:
    figures = cut_elements(board, places(board))
    assert figures == {"cut": 0, "mixed": 0, "part": 0, "swollen": 0, "torn": 0, "elements": 16, "crumbs": 0}


def test_elements_swapped_whole_are_not_cut(board: np.ndarray) -> None:
    where = places(board)
    where[:12], where[24:36] = where[24:36].copy(), where[:12].copy()
    assert cut_elements(board, where)["cut"] == 0


def test_halves_of_two_grown_together_are_mixed(board: np.ndarray) -> None:
    where = places(board)
    where[12:24, 12:18] = where[12:24, 24:30]
    figures = cut_elements(board, where)
    assert (figures["cut"], figures["mixed"], figures["part"]) == pytest.approx((1 / 16, 1 / 16, 1 / 16))


def test_a_sliver_of_another_is_let_pass(board: np.ndarray) -> None:
    where = places(board)
    where[12:24, 12:15] = where[12:24, 24:27]  # one column of eight, and two of ground
    assert cut_elements(board, where)["mixed"] == pytest.approx(1 / 16)
    where[14:19, 14] = where[14:19, 15]
    assert cut_elements(board, where)["mixed"] == 0


def test_an_element_that_ends_at_a_seam_is_a_part_but_not_at_the_border(board: np.ndarray) -> None:
    where = places(board)
    where[12:24, 12:18] = where[0, 0]
    figures = cut_elements(board, where)
    assert (figures["mixed"], figures["part"], figures["elements"]) == (0, pytest.approx(1 / 16), 16)
    assert cut_elements(board, places(board)[:, 6:])["cut"] == 0


def test_an_element_grown_onto_itself_is_swollen(board: np.ndarray) -> None:
    where = places(board)
    where[12:24, 12:24] = where[12:24, np.r_[12:20, 16:20]]
    figures = cut_elements(board, where)
    assert figures["swollen"] > 0
    assert figures["mixed"] == 0


def test_what_the_exemplar_cuts_is_a_part_unless_it_is_large(board: np.ndarray) -> None:
    small, large = board[:, 7:], board[:, 3:]  # three columns of eight, and seven
    for numbers, cut in ((small, True), (large, False)):
        where = np.full((20, 20), numbers.shape[1])  # ground
        where[4:12, 4:12] = places(numbers)[2:10, :8]
        where[:, 12:] = numbers.shape[1]
        assert cut_elements(numbers, where)["part"] == cut


def test_whole_elements_that_hardly_touch_are_two(board: np.ndarray) -> None:
    where = places(board)
    for row, cut in ((slice(17, 19), 0.0), (slice(14, 22), 2 / 16)):
        where[row, 20:26] = where[17, 18]
        where[row, 20:26] = np.where(np.arange(20, 26) < 23, where[17, 18], where[17, 27])
        assert cut_elements(board, where)["cut"] == pytest.approx(cut, abs=0.03)


def test_crumbs_are_no_elements(board: np.ndarray) -> None:
    where = np.zeros((30, 30), dtype=np.int64)
    where[10, 10] = places(board)[15, 15]
    figures = cut_elements(board, where)
    assert (figures["elements"], figures["crumbs"]) == (0, 1)
    assert math.isnan(figures["cut"])


def test_many_grown_together_count_as_many(board: np.ndarray) -> None:
    where = np.full((40, 40), places(board)[15, 15])
    where[:, 20:] = places(board)[15, 27]
    figures = cut_elements(board, where)
    assert figures["cut"] == 1
    assert figures["elements"] == pytest.approx(25)


@pytest.fixture
def cells() -> np.ndarray:
    """Sixteen elements of 12x12 pixels that touch."""
    return np.kron(np.arange(1, 17).reshape(4, 4), np.ones((12, 12), dtype=np.int64))


def test_of_elements_that_touch_those_are_one_that_are_torn(cells: np.ndarray) -> None:
    where = places(cells)
    figures = cut_elements(cells, where, touching=True)
    assert figures == {"cut": 0, "mixed": 0, "part": 0, "swollen": 0, "torn": 0, "elements": 16, "crumbs": 0}
    assert cut_elements(cells, where)["mixed"] == 1
    where[12:24, 12:24], where[24:36, 24:36] = where[24:36, 24:36].copy(), where[12:24, 12:24].copy()
    assert cut_elements(cells, where, touching=True)["cut"] == 0
    where = places(cells)
    where[12:24, 12:18] = where[12:24, 24:30]  # halves of two, torn along 12 pixels, of which 8 lie within both
    figures = cut_elements(cells, where, touching=True)
    assert (figures["mixed"], figures["part"]) == pytest.approx((1 / 16, 1 / 16))
    assert figures["torn"] == pytest.approx(8 / (6 * 48 + 12), abs=0.003)


def test_elements_that_end_on_the_ground_of_another_copy_are_torn(board: np.ndarray) -> None:
    where = places(board)
    where[14:22, 18:22] = where[22, 22]
    assert cut_elements(board, where)["torn"] == 0  # upon the ground's last pixel no seam is within it
    wide = np.pad(board, ((0, 0), (0, 12)))
    where = places(wide)
    where[14:22, 18:22] = where[8, 54]
    assert cut_elements(wide, where)["torn"] > 0


@pytest.mark.parametrize("name", MADE)
@pytest.mark.parametrize("size", [12, 32])
def test_made_elements_are_of_one_piece_and_apart_or_touch(name: str, size: int) -> None:
    made = MADE[name](128, size)
    numbers = made.numbers.numpy()
    assert made.image.shape == (3, 128, 128)
    assert 0 <= made.image.min() < made.image.max() <= 1
    for element in bench_elements._whole(numbers):
        assert ndimage.label(numbers == element, np.ones((3, 3)))[1] == 1
    if made.touching:
        assert (numbers > 0).mean() > 0.8
        return
    regions, count = ndimage.label(numbers > 0, np.ones((3, 3)))
    for region in range(1, count + 1):
        assert len(np.unique(numbers[regions == region])) == 1
    areas = np.bincount(numbers.ravel())
    assert 0 < areas[0] < 0.9 * numbers.size


def test_stones_are_of_one_brightness() -> None:
    made = MADE["stones"](128, 32)
    core = ndimage.binary_erosion(made.numbers > 0, iterations=8)
    light = np.tensordot([0.299, 0.587, 0.114], made.image.numpy(), 1)
    means = ndimage.mean(light, made.numbers.numpy() * core, np.unique(made.numbers.numpy() * core)[1:])
    colors = [ndimage.mean(channel, made.numbers.numpy() * core, np.unique(made.numbers.numpy() * core)[1:])
              for channel in made.image.numpy()]  # fmt: skip
    assert np.std(means) < 0.02 < 0.1 < np.std(colors, axis=1).max()


def test_the_table_has_controls_methods_and_frames(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["tiles", "coins", "patches", "--sizes", "12", "--side", "64", "--size", "72x64"]
    words += ["--seeds", "1", "--at", "0,2"]
    words += ["--methods", "fast", "quilting", "copies", "blocks", "--flows", "rotation"]
    assert bench_elements.main([*words, "--json", str(tmp_path / "figures.json")]) == 0
    rows = json.loads((tmp_path / "figures.json").read_text())
    names = {"fast", "quilting", "copies", "blocks", "rotation 0", "rotation 2"}
    exact = {"rotation 0 exact", "rotation 2 exact"}
    by = {(row["exemplar"], row["method"]): row["figures"] for row in rows}
    assert len(by) == len(rows)
    apart = "tiles 12", "coins 12"
    wanted = {(texture, name) for texture in apart for name in names | exact}
    assert set(by) == wanted | {("patches 12", name) for name in names}
    assert all(by[texture, "rotation 0 exact"]["cut"] == 0 for texture in apart)
    for texture in (*apart, "patches 12"):
        assert by[texture, "copies"]["cut"] == 0
        assert by[texture, "blocks"]["cut"] > 0.25
        assert by[texture, "fast"]["cut"] < by[texture, "blocks"]["cut"]
        assert all(0 <= by[texture, name]["cut"] <= 1 for name in names)
    assert "rotation 2" in capsys.readouterr().out


def test_a_texture_that_is_none_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        bench_elements.main(["gravel"])
    said = capsys.readouterr().err
    assert "no texture is named gravel; give some of stones, rubble, mosaic, coins, buttons, tiles, bricks" in said
