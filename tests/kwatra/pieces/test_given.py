"""Pixels that are given: they stay, and blocks go on from them."""

import numpy as np
import pytest
import torch
from textures import gravel, noise
from torch import Tensor

from kwatra import Exemplar
from kwatra.base import generator_of
from kwatra.pieces import BlockStart, Box
from kwatra.pieces.given import GivenCopies
from kwatra.pieces.layer import Layer


def stripes(height: int, width: int, begin: int = 0) -> Tensor:
    return ((torch.arange(begin, begin + width) % 6) < 2).float().expand(1, height, width).contiguous()


def shown(height: int, width: int, rows: slice, columns: slice, first: tuple[int, int]) -> Tensor:
    """Where pixels come from, if those in some rows and columns are copied from a first place on."""
    source = torch.full((2, height, width), -1)
    part = source[:, rows, columns]
    part[:] = torch.from_numpy(np.indices(part.shape[1:])) + torch.tensor(first)[:, None, None]
    return source


def laid(exemplar: Exemplar, source: Tensor, block: int = 20, seed: int = 0) -> BlockStart:
    shape = tuple(source.shape[1:])
    start = BlockStart(
        exemplar, shape, (block, block), (1, 1), generator_of(seed), usage=0.5, seams=6, given=source
    )  # fmt: skip
    start.run()
    return start


def test_what_is_given_stays_and_blocks_fill_the_rest_of_the_exemplar() -> None:
    image = noise(2, 48, 40)
    source = shown(60, 70, slice(10, 30), slice(20, 50), (5, 3))
    start = laid(Exemplar.of(image), source)
    assert start.sheet.filled.all()
    at = start.sheet.sources.coordinates(start.sheet.places)[1]
    given = (source >= 0).all(0).numpy()
    np.testing.assert_array_equal(at[:, given], source.numpy()[:, given])
    assert start.layer.used.sum() == (~given).sum()


@pytest.mark.parametrize("phase", [0, 2, 5])
def test_stripes_go_on_in_the_phase_of_those_that_are_given(phase: int) -> None:
    exemplar = Exemplar.of([stripes(48, 48)] * 2)
    start = laid(exemplar, shown(48, 160, slice(0, 48), slice(70, 90), (0, 12 + phase)), 40)
    image = exemplar.canvas[(slice(None), *start.where)]
    assert torch.equal(image[:, :, :70], stripes(48, 70, phase - 70))
    assert torch.equal(image[:, :, 90:], stripes(48, 70, phase + 20))
    assert start.sheet.total == 0


def test_what_is_shown_of_an_exemplar_is_its_values_where_they_are_given() -> None:
    values = np.random.default_rng(0).random((3, 48, 40))
    source = shown(50, 60, slice(13, 31), slice(22, 41), (5, 3))
    there = GivenCopies((50, 60), source).shown(values)
    np.testing.assert_array_equal(there[:, 13:31, 22:41], values[:, 5:23, 3:22])
    there[:, 13:31, 22:41] = 0
    assert not there.any()
    whole = GivenCopies((50, 60), None).shown(values[0])
    assert whole.shape == (50, 60)
    assert not whole.any()


def test_what_is_given_of_nobodys_pixels_is_an_image_of_its_own() -> None:
    mask = torch.ones(48, 40, dtype=torch.bool)
    mask[10:30, 5:20] = False
    exemplar = Exemplar.of([noise(1, 48, 40)], masks=[mask])
    given = GivenCopies((20, 20), shown(20, 20, slice(0, 9), slice(0, 8), (12, 7)))
    owned = given.owned(exemplar)
    assert (owned.owner[12:21, 7:15] == 1).all()
    assert int((owned.owner >= 0).sum()) == int(mask.sum()) + 72
    assert bool((exemplar.owner[12:21, 7:15] < 0).all())
    somebodys = GivenCopies((20, 20), shown(20, 20, slice(0, 9), slice(0, 8), (32, 7)))
    assert somebodys.owned(exemplar) is exemplar


def test_all_along_the_border_small_blocks_lie_with_it_in_their_middle() -> None:
    source = shown(50, 60, slice(13, 31), slice(22, 41), (0, 0))
    given = GivenCopies((50, 60), source)
    boxes = given.beside((8, 10), (2, 3), (1, 1))
    covered = np.zeros((50, 60), bool)
    for box in boxes:
        assert box.extent == (8, 10)
        assert box.within(Box((0, 0), (50, 60))) == box
        inside = given.where[box.start[0] : box.stop[0], box.start[1] : box.stop[1]]
        assert 0.15 < inside.mean() < 0.85
        covered[box.start[0] : box.stop[0], box.start[1] : box.stop[1]] = True
    assert covered[given.near(2) & ~given.where].all()
    on_grain = given.beside((8, 8), (2, 2), (4, 4))
    assert {start % 4 for box in on_grain for start in box.start} == {0}


def test_pixels_are_near_by_steps() -> None:
    given = GivenCopies((9, 9), shown(9, 9, slice(4, 5), slice(4, 5), (0, 0)))
    y, x = np.indices((9, 9))
    np.testing.assert_array_equal(given.near(3), abs(y - 4) + abs(x - 4) <= 3)


def test_copies_beside_what_is_given_go_on_under_it() -> None:
    given = GivenCopies((1, 6), shown(1, 6, slice(0, 1), slice(2, 4), (0, 0)))
    where = torch.tensor([[[0, 0, 9, 9, 5, 5]], [[7, 8, 0, 0, 1, 2]]])
    covered = given.covered(where, (8, 10))
    assert covered.tolist() == [[[0, 0, 0, 5, 5, 5]], [[7, 8, 9, 0, 1, 2]]]
    assert torch.equal(GivenCopies((1, 6), None).covered(where, (8, 10)), where)
    assert int(given.covered(where + 1, (8, 10))[1].max()) == 9  # as far as the canvas goes


def test_a_border_shows_less_where_blocks_go_on_from_what_is_given() -> None:
    """Beside blocks that are laid on it as on anything, given pixels would end in a line."""
    image = gravel(96, shrunk=2)
    source = shown(96, 96, slice(30, 66), slice(30, 66), (30, 30))
    given = (source >= 0).all(0).numpy()

    def steps(x: np.ndarray) -> float:
        found = [np.abs(np.diff(x, axis=axis))[np.diff(given, axis=axis)] for axis in (0, 1)]
        return float(np.concatenate(found).mean())

    exemplar = Exemplar.of(image)
    going_on, anyhow = 0.0, 0.0
    for seed in range(3):
        start = laid(exemplar, source, 24, seed)
        x = exemplar.canvas[0].numpy()[tuple(start.sheet.sources.coordinates(start.sheet.places)[1])]
        plain = laid(exemplar, torch.full_like(source, -1), 24, seed)
        y = exemplar.canvas[0].numpy()[tuple(plain.where.numpy())]
        going_on += steps(x)
        anyhow += steps(np.where(given, image[0].numpy(), y))
    assert going_on < 0.6 * anyhow


def test_of_what_is_given_of_another_texture_nothing_is_copied() -> None:
    texture, other = gravel(64), noise(1, 40, 40) / 2
    both = Exemplar.of([texture, other], masks=[None, torch.zeros(40, 40, dtype=torch.bool)])
    first = (both.origin[0] == 1).nonzero()[0].tolist()
    source = shown(64, 64, slice(12, 52), slice(12, 52), (first[0], first[1]))
    start = laid(both, source)
    given = (source >= 0).all(0)
    owner = both.owner[tuple(torch.from_numpy(start.sheet.sources.coordinates(start.sheet.places)[1]).long())]
    assert bool((owner[given] == -1).all())
    assert bool((owner[~given] == 0).all())
    assert start.gaps is None
    colors = start.sheet.sources.originals(start.sheet.places)[:, given.numpy()]
    np.testing.assert_array_equal(colors, other.reshape(1, -1).numpy())


def test_a_part_is_laid_anew_around_what_is_given(recomputed_seams) -> None:  # type: ignore[no-untyped-def]
    image = noise(1, 40, 40)
    source = shown(60, 60, slice(20, 40), slice(20, 40), (7, 9))
    start = laid(Exemplar.of(image), source)
    other = start.anew(Box((10, 10), (30, 30)), generator_of(1))
    given = (source >= 0).all(0).numpy()
    assert other.sheet.filled.all()
    np.testing.assert_array_equal(other.sheet.places[given], start.sheet.places[given])
    assert (other.sheet.places != start.sheet.places).any()
    assert other.layer.used.sum() == (~given).sum()
    np.testing.assert_array_equal(other.sheet.seams, recomputed_seams(other.sheet))


def test_boxes_come_nearest_first() -> None:
    given = GivenCopies((40, 40), shown(40, 40, slice(0, 4), slice(0, 40), (0, 0)))
    boxes = [Box((row, 8), (6, 6)) for row in (30, 2, 20, 10)]
    assert [box.start[0] for box in given.nearest_first(boxes)] == [2, 10, 20, 30]
    assert GivenCopies((40, 40), None).nearest_first(boxes) == boxes


@pytest.mark.parametrize(("block", "size"), [(20, 6), (40, 12), (100, 16)])
def test_blocks_beside_what_is_given_are_a_part_of_others_and_narrow(
    block: int, size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes, smaller = list[tuple[int, ...]](), Layer.smaller

    def seen(self: Layer, share: float) -> Layer:
        small = smaller(self, share)
        sizes.append(small.corners.block)
        return small

    monkeypatch.setattr(Layer, "smaller", seen)
    start = laid(Exemplar.of(noise(1, 120, 120)), shown(200, 200, slice(60, 100), slice(60, 100), (5, 3)), block)
    assert start.sheet.filled.all()
    assert sizes == [(size, size)]
