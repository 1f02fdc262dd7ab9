from unittest.mock import Mock

import numpy as np
import pytest
import torch
from skimage import data

from kwatra import InputError
from synth import fill, synthesize
from synth.texture.search import REFINED

QUICK = {"levels": ((2, 8), (1, 8)), "preset": "fast"}


def brick(size=72):
    return data.brick()[:size, :size]


@pytest.mark.parametrize(
    ("dtype", "channels"),
    [(np.uint8, None), (np.uint8, 3), (np.uint16, 1), (np.uint16, 4), (np.float32, None), (np.float32, 4),
     (np.float64, 3)],
)  # fmt: skip
def test_an_array_comes_out_as_it_went_in(dtype, channels):
    gray = brick().astype(np.float64) / 255
    image = gray if channels is None else np.stack([gray ** (1 + k) for k in range(channels)], -1)
    scale = np.iinfo(dtype).max if np.issubdtype(dtype, np.integer) else 1
    image = (image * scale).astype(dtype)
    made = synthesize(image, (50, 61), **QUICK).image
    assert made.dtype == dtype
    assert made.shape == (50, 61, *image.shape[2:])
    assert made.min() >= image.min()
    assert made.max() <= image.max()
    assert abs(float(made.mean()) / float(image.mean()) - 1) < 0.2


@pytest.mark.parametrize("of", [lambda a: a.astype(">f4"), lambda a: a[::-1].copy()[::-1]], ids=["bytes", "flipped"])
def test_an_array_may_lie_in_memory_as_it_likes(of):
    plain, hole = brick().astype(np.float32), np.zeros((72, 72), bool)
    hole[30:40, 30:40] = True
    for made in (lambda a: synthesize(a, (40, 40), preset="fast"), lambda a: fill(a, hole[:, ::-1], preset="fast")):
        assert np.array_equal(made(of(plain)).image, made(plain).image)


def test_a_tensor_comes_out_as_it_went_in():
    image = torch.from_numpy(brick().copy())[None]
    made = synthesize(image, (40, 40), **QUICK).image
    assert made.dtype == torch.uint8
    assert made.shape == (1, 40, 40)


def test_the_range_of_values_does_not_matter():
    image = brick().astype(np.float32)
    a = synthesize(image, (64, 64), **QUICK)
    b = synthesize(image * 100 - 7000, (64, 64), **QUICK)
    assert (a.source == b.source).mean() > 0.99
    assert np.median(np.abs(a.image * 100 - 7000 - b.image)) < 1


def test_a_map_is_rearranged_exactly_like_the_pixels():
    image = brick(96)
    made = synthesize(image, (90, 100), **QUICK)
    same = made.take(image)
    assert same.dtype == image.dtype
    # what the map holds are verbatim exemplar pixels, aligned with the blended picture
    assert np.median(np.abs(same.astype(float) - made.image)) <= 1
    labels = np.arange(96 * 96).reshape(96, 96)
    assert np.array_equal(made.take(labels), made.source[1] * 96 + made.source[2])
    assert made.take(np.stack([labels, labels], -1)).shape == (90, 100, 2)
    assert torch.equal(made.take(torch.from_numpy(labels)[None])[0], torch.from_numpy(made.take(labels)))


def test_several_exemplars_are_all_used_and_told_apart():
    a, b = data.gravel()[:48, :48], data.gravel()[200:260, 200:260]
    made = synthesize([a, b], (120, 130), **QUICK)
    assert set(np.unique(made.source[0])) == {0, 1}
    taken = made.take([np.zeros((48, 48), int), np.ones((60, 60), int)])
    assert np.array_equal(taken, made.source[0])
    with pytest.raises(InputError, match="give one for each"):
        made.take([a])
    with pytest.raises(InputError, match=r"a map has size \(48, 48\) but its image \(60, 60\); give maps of"):
        made.take([np.zeros((48, 48)), np.zeros((48, 48))])
    with pytest.raises(InputError, match=r"a map has size \(64, 48\)"):
        made.take([torch.zeros(1, 64, 48), torch.zeros(1, 60, 60)])


@pytest.mark.parametrize("options", [{"mirror": True}, {"rotate": (90,)}, {"scale": (0.7,)}])
def test_sources_of_transformed_copies_lie_in_the_original(options):
    made = synthesize(brick(64), (60, 60), **QUICK, **options)
    assert made.source[0].max() == 0
    assert made.source[1:].min() >= 0
    assert made.source[1:].max() < 64


def seam(image, axis):
    """Mean jump over the border when the image is repeated, relative to the mean jump elsewhere."""
    step = np.abs(np.diff(image.astype(float), axis=axis)).mean()
    over = np.abs(image.take(0, axis).astype(float) - image.take(-1, axis)).mean()
    return over / step


@pytest.mark.parametrize("size", [(96, 96), (101, 90)])
def test_a_tile_repeats_without_a_seam(size):
    gravel = data.gravel()[:128, :128]
    tile = synthesize(gravel, size, tile=True, preset="fast").image
    plain = synthesize(gravel, size, preset="fast").image
    assert max(seam(tile, 0), seam(tile, 1)) < 1.5
    assert max(seam(plain, 0), seam(plain, 1)) > 1.5


@pytest.mark.parametrize(("side", "size"), [(4, (16, 16)), (12, (5, 5))])
def test_the_best_of_several_runs_is_chosen_among_the_smallest_pictures_too(side, size):
    made = synthesize(brick(side), size, preset="best")
    assert made.image.shape == size
    assert set(made.image.ravel()) <= set(range(int(brick(side).min()), int(brick(side).max()) + 1))


def ranking(rank):
    """What ranks by a function, and needs no description."""
    figure = Mock(side_effect=rank)
    return lambda pictures, thorough: figure


@pytest.mark.usefixtures("in_turn")
def test_the_best_of_several_runs_is_the_one_of_least_rank(monkeypatch):
    ranked = []

    def rank(image):
        ranked.append((0.5 - 0.1 * (len(ranked) == 3) + 0.1 * (len(ranked) == 1), image))
        return ranked[-1][0]

    monkeypatch.setattr("synth.texture.runs.Ranking", ranking(rank))
    made = synthesize(brick(24), (24, 24), preset="best", levels=((1, 8),), mask=np.ones((24, 24), bool))
    assert len(ranked) == 6
    assert torch.equal(made.result.image, ranked[3][1])
    assert not any(torch.equal(made.result.image, image) for _, image in (*ranked[:3], *ranked[4:]))


@pytest.mark.parametrize(
    ("size", "options", "count"),
    [((32, 32), {}, 6 + REFINED), ((64, 64), {}, 3 + REFINED), ((64, 256), {}, 1), ((32, 32), {"preset": "fast"}, 1),
     ((32, 32), {"mask": np.ones((32, 32), bool)}, 1)],
)  # fmt: skip
def test_small_outputs_are_tried_more_often_than_large_and_steered_ones(size, options, count, monkeypatch):
    monkeypatch.setattr("synth.texture.work.SMALL", 32)
    tries = []
    synthesize(brick(32), size, levels=((1, 8),), **options, callback=lambda p: tries.append((p.attempt, p.tries)))
    assert set(tries) == {(1 + number, count) for number in range(count)}


def test_the_best_of_several_runs_reports_growing_progress():
    seen = []
    synthesize(brick(20), (20, 20), preset="best", levels=((1, 8),), callback=lambda p: seen.append(p.fraction))
    assert seen == sorted(seen)
    assert 0.75 < seen[-1] <= 1


@pytest.mark.parametrize(("pixels", "together"), [(40 * 40 * 2, 1), (40 * 40 * 2 - 1, 2)])
def test_runs_are_made_side_by_side_where_memory_allows_and_the_same_is_kept(pixels, together, in_turn, monkeypatch):
    used = []
    monkeypatch.setattr("synth.texture.runs.BESIDE", pixels)
    rank = ranking(lambda image: used.append(torch.get_num_threads()) or float(image.mean()))
    monkeypatch.setattr("synth.texture.runs.Ranking", rank)
    made, steered = [], {"mask": np.ones((40, 40), bool), "preset": "best"}
    for threads in (1, 2):
        torch.set_num_threads(threads)
        made.append(synthesize(brick(40), (40, 40), levels=((1, 8),), seed=2, **steered).image)
    assert used == [1] * 6 + [together] * 6
    assert np.array_equal(*made)


def test_the_thesis_levels_are_a_named_choice():
    made = synthesize(brick(136), (136, 136), levels="thesis", preset="fast")
    assert [(stage.factor, stage.width) for stage in made.result.stages] == [
        (4, 8), (2, 16), (2, 8), (1, 32), (1, 16), (1, 8),
    ]  # fmt: skip


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a CUDA device")
def test_cuda_gives_the_same_quality():
    from kwatra import measure

    image = torch.from_numpy(brick(128).copy())[None].float() / 255
    scores = [measure(synthesize(image, (128, 128), device=d).image, image)["overall"] for d in ("cpu", "cuda")]
    assert scores[1] < 1.2 * scores[0]


@pytest.mark.parametrize(
    ("exemplar", "options", "message"),
    [
        ([], {}, "no exemplar was given"),
        (np.zeros((4, 4, 3, 2, 1)), {}, r"give tensors \(C, H, W\)"),
        (np.zeros((4, 4, 3, 2)), {}, "number of frames, height and width"),
        (np.full((32, 32), np.nan), {}, "NaN or infinite"),
        ([np.zeros((32, 32)), torch.zeros(1, 32, 32)], {}, "all of one kind"),
        (np.zeros((32, 32)), {"preset": "wild"}, "allowed are fast, default, best"),
        (np.zeros((32, 32)), {"levels": "mine"}, "give 'thesis'"),
        (np.zeros((32, 32)), {"start": np.zeros((9, 9))}, "the start image has shape"),
    ],
)
def test_unusable_input_is_said_in_a_sentence(exemplar, options, message):
    with pytest.raises(InputError, match=message):
        synthesize(exemplar, (32, 32), **options)


@pytest.mark.parametrize("size", [(0, 5), (-3, 9), (float("nan"), 9), ("40", 9), 40, (40.5, 9), (9,)])
def test_a_size_that_is_none_is_refused(size):
    with pytest.raises(InputError, match="give 2 whole numbers of pixels, each at least 1"):
        synthesize(brick(24), size)


@pytest.mark.parametrize("exemplar", [None, "brick.png", brick(24).tolist()])
def test_an_exemplar_that_is_no_image_is_refused(exemplar):
    with pytest.raises(InputError, match=r"an exemplar is a \w+; give tensors"):
        synthesize(exemplar, (24, 24))


def test_images_whose_numbers_mean_other_things_are_not_mixed():
    hole = np.zeros((24, 24), bool)
    hole[8:12, 8:12] = True
    with pytest.raises(InputError, match="an exemplar holds float64 but another uint8; give all of one type"):
        fill(brick(24), hole, exemplar=brick(24) / 255)
    assert synthesize([brick(24) / 255, (brick(24) / 255).astype(">f4")], (24, 24), **QUICK).image.dtype == np.float64


def test_a_tensor_that_asks_for_derivatives_is_a_picture_like_any():
    plain = torch.from_numpy(brick(32) / 255).float()[None]
    made = synthesize(plain.clone().requires_grad_(), (24, 24), **QUICK)
    assert torch.equal(made.image, synthesize(plain, (24, 24), **QUICK).image)
    assert torch.equal(made.take(plain.clone().requires_grad_()), made.take(plain))


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"seed": None}, "the seed is None"),
        ({"device": "nowhere"}, "the device 'nowhere' cannot be used"),
        ({"levels": 5}, "levels is 5; give 'thesis', or pairs"),
        ({"levels": [(4, 16, 2)]}, "give 'thesis', or pairs"),
        ({"levels": [(3, 16)]}, "a level's factor is 3; allowed are 1, 2, 4 and 8"),
        ({"exemplar_mask": np.zeros((24, 24), bool)}, "leave nothing to copy from"),
    ],
)
def test_options_that_cannot_be_are_refused(options, sentence):
    with pytest.raises(InputError, match=sentence):
        synthesize(brick(24), (24, 24), **options)
