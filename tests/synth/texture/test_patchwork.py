"""Several textures in one picture: each as it is made alone, where it is wanted."""

import numpy as np
import pytest
import torch
from bench_elements import cut_elements
from made import MADE
from skimage import data

from synth import InputError, synthesize
from synth.texture import labels

BRICK, GRASS, GRAVEL = (image[:96, :96] for image in (data.brick(), data.grass(), data.gravel()))
HALVES = np.where(np.arange(120) < 60, 0, 255).astype(np.uint8)[None].repeat(90, 0)


def side_by_side(one: np.ndarray = BRICK) -> tuple[np.ndarray, np.ndarray]:
    return np.hstack([one, GRASS]), np.where(np.arange(192) < 96, 0, 255).astype(np.uint8)[None].repeat(96, 0)


def test_each_texture_is_as_it_is_made_alone() -> None:
    both, there = side_by_side(GRAVEL)  # around bricks borders lie further off
    made = synthesize(both, guide=(there, HALVES), seed=3, preset="fast")
    assert (made.image.shape, made.image.dtype) == ((90, 120), np.uint8)
    alone = synthesize(GRASS, (90, 65), seed=3, preset="fast")  # a border may lie 4 pixels off, and looks behind it
    np.testing.assert_array_equal(made.image[:, 64:], alone.image[:, 9:])
    np.testing.assert_array_equal(made.source[:, :, 64:], alone.source[:, :, 9:] + np.array([0, 0, 96])[:, None, None])
    wrong = made.take(there) != HALVES
    assert not wrong[:, :56].any()
    assert not wrong[:, 64:].any()
    assert [row["label"] for row in made.result.energies] == sorted(row["label"] for row in made.result.energies)


def test_exemplars_of_their_own_are_the_same_as_side_by_side() -> None:
    both, there = side_by_side()
    one = synthesize(both, guide=(there, HALVES), seed=1, preset="fast")
    other = synthesize([BRICK, GRASS], guide=labels([BRICK, GRASS], HALVES), seed=1, preset="fast")
    np.testing.assert_array_equal(one.image, other.image)
    assert set(other.source[0].ravel()) == {0, 1}
    np.testing.assert_array_equal(one.source[2], other.source[2] + 96 * other.source[0])
    np.testing.assert_array_equal(other.take([BRICK, GRASS])[:, :50], one.take(both)[:, :50])


def test_tensors_floats_and_other_ranges_are_restored() -> None:
    both, there = side_by_side()
    pixels = torch.from_numpy(both.astype(np.float32) * 3 - 50)[None]
    guide = torch.from_numpy(there).float()[None], torch.from_numpy(HALVES).float()[None]
    made = synthesize(pixels, guide=guide, seed=3, preset="fast")
    assert made.image.shape == (1, 90, 120)
    whole = synthesize(both, guide=(there, HALVES), seed=3, preset="fast")
    same = torch.from_numpy(whole.source == made.source.copy()).all(0)
    assert float(same.double().mean()) > 0.95
    assert float((made.image[0] - (torch.from_numpy(whole.image).float() * 3 - 50))[same].abs().max()) < 3.1
    torch.testing.assert_close(made.image, made.form.restored(made.result.image))


def test_fewer_elements_are_cut_than_borders_would() -> None:
    coins, stones = MADE["coins"](160, 24, 0), MADE["stones"](160, 24, 1)
    images = [made.image for made in (coins, stones)]
    wanted = torch.zeros(1, 160, 160)
    y, x = torch.meshgrid(torch.arange(160), torch.arange(160), indexing="ij")
    wanted[0] = ((y - 80) ** 2 + (x - 80) ** 2 < 50**2).float()
    made = synthesize(images, guide=labels(images, wanted), seed=0, preset="fast")
    numbers = coins.numbers.numpy()
    places = made.take([np.arange(160 * 160).reshape(160, 160)] * 2)
    ground = np.flatnonzero(numbers == 0)[0]

    def cut(shown: np.ndarray, places: np.ndarray) -> float:
        return cut_elements(numbers, np.where(shown, places, ground))["cut"]

    own = cut(made.source[0] == 0, places)
    whole = synthesize(coins.image, (160, 160), seed=0, preset="fast").take(np.arange(160 * 160).reshape(160, 160))
    assert own < 0.6 * cut(wanted[0].numpy() == 0, whole)
    assert np.mean((made.source[0] == 1) != wanted[0].numpy()) < 0.15


def test_what_tiles_meets_itself() -> None:
    both, there = side_by_side()
    made = synthesize(both, guide=(there, HALVES), seed=0, preset="fast", tile=True)
    alone = synthesize(BRICK, (90, 120), seed=0, preset="fast", tile=True)
    np.testing.assert_array_equal(made.image[:, 8:52], alone.image[:, 8:52])


def test_light_is_taken_out_of_each_texture_by_itself() -> None:
    lit = (GRAVEL.astype(float) * np.linspace(0.4, 1, 96)).astype(np.uint8)
    lit = np.hstack([lit, lit[:, ::-1]]).repeat(2, 0)
    there = np.where(np.arange(384) < 192, 0, 255).astype(np.uint8)[None].repeat(192, 0)
    made = synthesize(np.hstack([lit, GRASS.repeat(2, 0).repeat(2, 1)]), guide=(there, HALVES), preset="fast")
    if made.even:  # of grass nothing changes
        (even,) = made.even
        np.testing.assert_array_equal(even[:, 192:], GRASS.repeat(2, 0).repeat(2, 1))


def test_variants_are_turned_as_they_lie() -> None:
    both, there = side_by_side()
    made = synthesize(both, guide=(there, HALVES), preset="fast", mirror=True)
    assert made.turns is not None
    assert made.turns.shape == (2, 2, 90, 120)
    assert set(np.unique(np.abs(np.linalg.det(made.turns.transpose(2, 3, 0, 1))).round(6))) == {1.0}


def test_any_number_of_threads_makes_the_same() -> None:
    both, there = side_by_side()
    made = []
    before = torch.get_num_threads()
    for threads in (1, 3):
        torch.set_num_threads(threads)
        made.append(synthesize(both, guide=(there, HALVES), seed=2).image)
    torch.set_num_threads(before)
    np.testing.assert_array_equal(*made)


def test_progress_is_of_all_textures() -> None:
    both, there = side_by_side()
    told: list[float] = []
    synthesize(both, guide=(there, HALVES), preset="fast", callback=lambda p: told.append(p.fraction))
    assert told == sorted(told)
    assert told[-1] == pytest.approx(1)
    assert min(told) <= 0.5


@pytest.mark.parametrize("asked", ["mask", "start", "levels", "exemplar_mask", "stay"])
def test_where_more_is_asked_the_guide_steers_one_texture(asked: str) -> None:
    both, there = side_by_side()
    options = {
        "mask": np.ones((90, 120), bool),
        "start": np.zeros((90, 120), np.uint8),
        "levels": [(2, 8), (1, 8)],
        "exemplar_mask": np.ones(both.shape, bool),
        "stay": 0.1,
    }
    made = synthesize(both, guide=(there, HALVES), preset="fast", **{asked: options[asked]})
    assert "guide" in made.result.energies[-1]


def test_what_cannot_be_used_is_refused_as_elsewhere() -> None:
    both, there = side_by_side()
    for options, message in [
        ({"loop": True}, "a loop is for videos"),
        ({"preset": "good"}, "the preset is 'good'"),
        ({"size": (80, 80)}, r"the size is \(80, 80\) but the guide's output map"),
        ({"guide_weight": -1.0}, "the guide's weight is -1.0"),
    ]:
        with pytest.raises(InputError, match=message):
            synthesize(both, guide=(there, HALVES), **options)
