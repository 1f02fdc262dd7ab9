import pytest
import torch
from made import MADE

from kwatra import Exemplar
from kwatra.elements import LOOKED_AT, Lattice, Rows, continued, find_lattice, find_repeats, out_of_step
from kwatra.source import look_up


def periodic(shape, first, second, seed=0):
    """Random pixels that repeat by two whole vectors (down, right); the first of them is (down, 0)."""
    cell = torch.rand(3, first[0] * 100, second[1], generator=torch.Generator().manual_seed(seed))[:, : first[0]]
    y, x = torch.meshgrid(*(torch.arange(s) for s in shape), indexing="ij")
    step = y // first[0]
    return cell[:, y % first[0], (x - step * first[1]) % second[1]]


def test_a_texture_repeats_by_its_lattice_or_else_by_its_rows_however_large_it_is():
    """What is found in a part is found in the whole, which is looked at with a half of the resolution."""
    for kind, repeats in (("bricks", Lattice), ("letters", Rows)):
        image = MADE[kind](400, 32, 0).image
        assert image[0].numel() > LOOKED_AT
        part, whole = find_repeats(Exemplar.of(image[:, :200, :200])), find_repeats(Exemplar.of(image))
        assert type(part) is type(whole) is repeats
        vectors = whole.vectors if isinstance(whole, Lattice) else whole.across[None]
        assert float(part.rest(vectors.T).norm(dim=0).max()) < 0.5
        assert float(whole.coarser(4).rest(vectors.T / 4).norm(dim=0).max()) < 1e-9
    assert find_repeats(Exemplar.of(MADE["stones"](400, 32, 0).image)) is None


@pytest.mark.parametrize(
    ("first", "second"), [((16, 0), (0, 16)), ((9, 4), (0, 14)), ((13, 20), (0, 31)), ((40, 9), (0, 44))]
)
@pytest.mark.parametrize("shape", [(128, 128), (40, 200), (300, 71)])
def test_a_periodic_picture_is_continued_exactly(first, second, shape):
    exemplar = Exemplar.of(periodic((96, 90), first, second))
    where = continued(exemplar, shape)
    assert torch.equal(look_up(exemplar.canvas, where), periodic(shape, first, second))


def test_a_checkerboard_of_eighty_five_pixels_is_continued_exactly():
    y, x = torch.meshgrid(torch.arange(320), torch.arange(320), indexing="ij")
    board = (((y + 7) // 32 + (x + 1) // 32) % 2).float()[None]
    exemplar = Exemplar.of(board[:, :85, :85])
    assert torch.equal(look_up(exemplar.canvas, continued(exemplar, (320, 320))), board)


def test_a_picture_that_repeats_in_half_pixels_is_continued_by_twice_the_vector():
    y, x = torch.meshgrid(torch.arange(128), torch.arange(128), indexing="ij")
    wave = ((torch.sin(2 * torch.pi * y / 12.5) + torch.sin(2 * torch.pi * x / 9)) / 4 + 0.5)[None]
    exemplar = Exemplar.of(wave[:, :64, :64])
    assert torch.allclose(look_up(exemplar.canvas, continued(exemplar, (128, 128))), wave, atol=1e-4)


def test_holes_are_gone_around():
    image, mask = periodic((96, 90), (9, 4), (0, 14)), torch.ones(96, 90, dtype=torch.bool)
    mask[:30, :40] = False
    exemplar = Exemplar.of(torch.where(mask, image, 0.0), masks=[mask])
    where = continued(exemplar, (128, 128))
    assert bool((exemplar.owner[tuple(where)] == 0).all())
    assert torch.equal(look_up(exemplar.canvas, where), periodic((128, 128), (9, 4), (0, 14)))


def test_the_second_picture_serves_where_the_first_is_not_periodic():
    broken = periodic((96, 90), (9, 4), (0, 14))
    broken[:, 50:60, 50:60] = 0.0
    exemplar = Exemplar.of([broken, periodic((96, 90), (9, 4), (0, 14))])
    where = continued(exemplar, (64, 64))
    assert bool((exemplar.owner[tuple(where)] == 1).all())
    assert continued(Exemplar.of(broken), (64, 64)) is None


def test_a_picture_that_is_only_nearly_periodic_is_not_continued():
    image = periodic((96, 90), (9, 4), (0, 14))
    noisy = Exemplar.of(image + 0.02 * torch.randn(image.shape, generator=torch.Generator().manual_seed(0)))
    assert find_lattice(noisy) is not None
    assert continued(noisy, (64, 64)) is None


def test_translations_by_lattice_vectors_are_in_step():
    lattice = Lattice(torch.tensor([[10.0, 2.0], [-3.0, 12.0]], dtype=torch.float64), 1.0)
    steps = out_of_step(lattice, (-20, -30), (60, 70))
    assert steps.shape == (60, 70)
    for point in ((0, 0), (10, 2), (-3, 12), (7, 14), (-13, 10)):
        assert float(steps[point[0] + 20, point[1] + 30]) == pytest.approx(0, abs=1e-6)
    assert float(steps[20 + 1, 30]) == pytest.approx(1)
    assert int((steps < 0.5).sum()) == pytest.approx(60 * 70 / 126, abs=6)


def test_translations_on_a_grain_are_those_of_the_full_map():
    lattice = Lattice(torch.tensor([[10.3, 2.0], [-3.0, 12.8]], dtype=torch.float64), 1.0)
    full = out_of_step(lattice, (4, -7), (40, 40))
    assert torch.equal(out_of_step(lattice, (4, -7), (10, 5), grain=(4, 8)), full[::4, ::8])


@pytest.mark.parametrize("first", [(0, 0), (-37, 12), (70, -101)])
def test_a_periodic_picture_is_continued_from_any_place_on(first):
    whole = periodic((300, 300), (13, 20), (0, 31))
    exemplar = Exemplar.of(whole[:, 130:226, 120:210])
    where = continued(exemplar, (50, 60), first)
    top, left = 130 + first[0], 120 + first[1]
    assert torch.equal(look_up(exemplar.canvas, where), whole[:, top : top + 50, left : left + 60])
