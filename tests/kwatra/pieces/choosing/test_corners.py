import contextlib

import numpy as np
import pytest
import torch

from kwatra import Exemplar, InputError
from kwatra.base.spans import of_volume, volume
from kwatra.pieces import BlockStart
from kwatra.pieces.choosing.comparing import cover
from kwatra.pieces.choosing.corners import Corners
from kwatra.pieces.choosing.weighing import wear

BLOCK, HANG, GRAIN, SHAPE = (6, 4), (4, 2), (2, 2), (14, 11)


def corners():
    return Corners.fitting(Exemplar.of(torch.rand(1, *SHAPE)), BLOCK, GRAIN).hanging(HANG)


def inside(at):
    """Which pixels of a block at a corner lie in the exemplar."""
    rows, columns = (np.arange(b) + c for b, c in zip(BLOCK, at, strict=True))
    return ((rows >= 0) & (rows < SHAPE[0]))[:, None] & ((columns >= 0) & (columns < SHAPE[1]))


def test_corners_lie_on_the_grain_and_as_far_beyond_the_border_as_asked():
    found = corners()
    every = found.at(np.arange(found.valid.size)).tolist()
    assert min(every) == [-4, -2]
    assert max(every) == [14 - 6 + 4, 8]  # 8 + 4 reaches one pixel beyond 11: the next on the grain would be 3
    assert found.valid.all()


@pytest.mark.parametrize("seed", range(3))
def test_what_continues_a_copy_is_counted_where_a_block_would_have_it(seed):
    rng, found = np.random.default_rng(seed), corners()
    first = found.at(np.arange(found.valid.size))[[seed * 7, seed * 5 + 3]].T
    place = np.indices(BLOCK)[:, None] + first[:, :, None, None]
    place[:, rng.random((2, *BLOCK)) < 0.4] += rng.integers(-9, 10, (2, 1))  # some are of elsewhere, or of no block
    place %= np.array(SHAPE)[:, None, None, None]
    known = rng.random((2, *BLOCK)) < 0.7
    expected = np.zeros((2, *found.valid.shape))
    for box, *pixel in np.argwhere(known):
        number = [(p - u + h) // g for p, u, h, g in zip(place[:, box, *pixel], pixel, HANG, GRAIN, strict=True)]
        if all(0 <= n < count for n, count in zip(number, found.valid.shape, strict=True)):
            expected[box, *number] += 1
    assert (expected.max((1, 2)) > 3).all()
    np.testing.assert_array_equal(found.continuing((place[0] + 1) * (SHAPE[1] + 2) + place[1] + 1, known), expected)


def covering(found, needed, known):
    """Which blocks cover what boxes need (b, *E), (b, *n)."""
    every = np.empty((len(needed), found.valid.size), bool)
    for box, row in enumerate(every):
        cover(volume(needed[box], 2), volume(known[box], 2), found.frame, row)
    return every.reshape(len(needed), *found.valid.shape)


def test_blocks_cover_what_is_needed_where_all_of_it_lies_inside():
    found, needed = corners(), np.zeros((3, *BLOCK), bool)
    known = np.zeros_like(needed)
    assert covering(found, needed, known).all()
    needed[0, 2, 1] = needed[0, 4, 2] = needed[0, 3, 1] = needed[2, 0, 3] = True
    every = found.at(np.arange(found.valid.size))
    known[1, 5, 0] = known[0, 0, 0] = True
    expected = [[bool(inside(at)[box].all()) for at in every] for box in needed]
    np.testing.assert_array_equal(covering(found, needed | known, known).reshape(3, -1), expected)
    assert 0 < sum(expected[0]) < len(expected[0])
    assert expected[0] != expected[2]
    assert all(expected[1])
    found.valid[0] = False
    assert not covering(found, needed, known)[:, 0].any()


def test_sums_are_those_of_what_lies_inside():
    rng, found = np.random.default_rng(0), corners()
    image, content = rng.random(SHAPE), rng.random((3, *BLOCK))
    sums, within = found.sums(np.pad(image, 1, constant_values=9)[None])[0], found.inside(content)
    for number, at in enumerate(found.at(np.arange(found.valid.size))):
        here, index = inside(at), np.unravel_index(number, found.valid.shape)
        rows, columns = np.nonzero(here)
        assert sums[index] == pytest.approx(image[rows + at[0], columns + at[1]].sum())
        np.testing.assert_allclose(within[:, *index], content[:, here].sum(1))


@pytest.mark.parametrize(
    ("block", "grain", "fits", "least"),
    [((12, 12), (1, 1), (6, 6), "2x2"), ((14, 14), (4, 4), (4, 4), "4x4"), ((7, 3), (1, 1), (6, 2), "2x2")],
)
def test_blocks_are_made_smaller_until_they_fit_between_holes(block, grain, fits, least):
    mask = torch.ones(16, 16, dtype=torch.bool)
    mask[::7] = False
    assert Corners.fitting(Exemplar.of(torch.rand(1, 16, 16), masks=[mask]), block, grain).block == fits
    mask[:, ::2] = False
    with pytest.raises(InputError, match=f"no free {least} block"):
        Corners.fitting(Exemplar.of(torch.rand(1, 16, 16), masks=[mask]), block, grain)


@pytest.mark.parametrize("grain", [4, 8])
def test_blocks_are_never_smaller_than_what_they_start_on(grain):
    """The pixels between them would stay empty."""
    mask = torch.ones(64, 64, dtype=torch.bool)
    mask[::7, ::3] = False
    exemplar = Exemplar.of(torch.rand(1, 64, 64), masks=[mask])
    for find in (Corners.fitting, Corners.on_holes):
        with contextlib.suppress(InputError):
            assert min(find(exemplar, (32, 32), (grain, grain)).block) >= grain


@pytest.mark.parametrize(("hole", "fits"), [(21, 20), (20, 17)])
def test_blocks_fit_in_more_places_than_a_few_unless_they_are_the_smallest(hole, fits):
    mask = torch.ones(40, 40, dtype=torch.bool)
    mask[:, hole] = False  # of 21 x 21 places those of 2 columns are left, or those of 1
    assert Corners.fitting(Exemplar.of(torch.rand(1, 40, 40), masks=[mask]), (20, 20), (1, 1)).block == (fits, fits)
    mask[:] = False
    mask[7:9, 20:22] = mask[30, 30] = mask[1, 1] = True
    fitted = Corners.fitting(Exemplar.of(torch.rand(1, 40, 40), masks=[mask]), (20, 20), (1, 1))
    assert (fitted.block, fitted.valid.sum()) == ((2, 2), 1)


def test_of_small_blocks_some_places_do():
    mask = torch.zeros(64, 64, dtype=torch.bool)
    mask[::9, ::9] = True  # so that all of it is within bounds
    mask[10:17, 10:20] = mask[40:47, 40:50] = True  # 8 places for 7 x 7, 20 for 6 x 6
    assert Corners.fitting(Exemplar.of(torch.rand(1, 64, 64), masks=[mask]), (20, 20), (1, 1)).block == (6, 6)


def test_a_block_may_be_as_large_as_an_exemplar_without_holes():
    for rotate in ((), (45.0,)):
        found = Corners.fitting(Exemplar.of(torch.rand(1, 12, 16), rotate=rotate), (12, 16), (1, 1))
        assert found.block == (12, 16)


def test_the_border_of_an_exemplar_is_shown_too():
    image = torch.rand(3, 64, 64, generator=torch.Generator().manual_seed(0))
    shown = np.zeros((64, 64))
    for seed in range(3):
        generator = torch.Generator().manual_seed(seed)
        where = BlockStart(Exemplar.of(image), (96, 96), (32, 32), (1, 1), generator, usage=0.5, seams=6).run()
        np.add.at(shown, tuple(where.numpy()), 1)
    border = np.ones((64, 64), bool)
    border[8:-8, 8:-8] = False
    assert shown[border].mean() > 0.5 * shown[~border].mean()  # .54; .39 were no block to hang over


def test_blocks_cost_what_their_pixels_were_used_more_than_all_on_average():
    image = torch.rand(1, 24, 20, generator=torch.Generator().manual_seed(0))
    start = BlockStart(
        Exemplar.of(image), (40, 40), (8, 8), (1, 1), torch.Generator().manual_seed(0), usage=0.5, seams=1
    )
    start.run()
    found, used = start.layer.corners, volume(start.layer.shown[None], 2)
    worn = wear(used, of_volume(found.under), found.pixels.ravel(), 0.5, 24 * 20)
    for number, at in enumerate(found.at(np.arange(found.valid.size)).tolist()):
        within = tuple(slice(max(c, 0), max(c + b, 0)) for c, b in zip(at, found.block, strict=True))
        assert worn[number] == pytest.approx(0.5 * (start.layer.used[within].mean() - start.layer.used.mean()))
    assert worn.std() > 0.1
