import pytest
import torch
from skimage import data

from kwatra import Exemplar, InputError
from kwatra.pieces.start import BlockStart, block_size
from kwatra.terms.controls import Wish


def stripes(height, width, period):
    return ((torch.arange(width) % period) < period // 2).float().expand(1, height, width).contiguous()


def run(exemplar, shape, block, grain=(1, 1), seed=0, **options):
    start = BlockStart(exemplar, shape, block, grain, torch.Generator().manual_seed(seed), **options)
    return start, start.run()


@pytest.mark.parametrize("wrap", [False, True])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_blocks_of_a_periodic_exemplar_continue_its_period(wrap, seed):
    start, where = run(Exemplar.of(stripes(48, 48, 12)), (72, 96), (24, 24), seed=seed, wrap=wrap)
    assert torch.equal(start.x, stripes(72, 96, 12).roll(-int(where[1, 0, 0]) % 12, 2))


def test_the_map_says_where_the_pixels_come_from_and_offsets_lie_on_the_grain():
    image = torch.rand(2, 64, 60, generator=torch.Generator().manual_seed(0))
    start, where = run(Exemplar.of(image), (70, 90), (24, 20), (4, 4))
    assert torch.equal(start.x, image[(slice(None), *where)])
    place = torch.stack(torch.meshgrid(torch.arange(70), torch.arange(90), indexing="ij"))
    assert int(((where - place) % 4).abs().max()) == 0


def test_aligned_blocks_fit_better_than_random_ones():
    image = (
        torch.rand(1, 16, 16, generator=torch.Generator().manual_seed(0))
        .repeat_interleave(4, 1)
        .repeat_interleave(4, 2)
    )

    def breaks(aligned):
        x = run(Exemplar.of(image), (96, 96), (24, 24), aligned=aligned)[0].x
        return int((x.diff(dim=2) != 0).sum() + (x.diff(dim=1) != 0).sum())

    assert breaks(True) < breaks(False)


@pytest.mark.parametrize("seed", [0, 1])
def test_blocks_with_cheaper_seams_are_laid(seed):
    image = torch.from_numpy(data.gravel()[:64, :64].astype("float32") / 255)[None]

    def read(place):
        y, x = place.clamp(0, 63)
        return image[0, y, x]

    def seams(count):
        _, where = run(Exemplar.of(image), (128, 128), (24, 24), seed=seed, seams=count, usage=0.0)
        place = torch.stack(torch.meshgrid(torch.arange(128), torch.arange(128), indexing="ij"))
        offset, cost = where - place, 0.0
        for axis in (1, 2):
            p, q = (place.narrow(axis, k, 127) for k in (0, 1))
            mine, theirs = (offset.narrow(axis, k, 127) for k in (0, 1))
            cost += sum(float((read(at + mine) - read(at + theirs)).abs().sum()) for at in (p, q))
        return cost

    assert seams(8) < seams(1)


def test_usage_spreads_the_blocks_over_the_exemplar():
    image = torch.full((1, 64, 64), 0.5)  # every block fits: only usage decides

    def unevenness(usage):
        start, _ = run(Exemplar.of(image), (128, 128), (16, 16), usage=usage)
        return float(start.used.std())

    assert unevenness(1.0) < 0.8 * unevenness(0.0)


def test_blocks_avoid_holes():
    mask = torch.ones(40, 40, dtype=torch.bool)
    mask[18:22, 18:22] = False
    _, where = run(Exemplar.of([torch.rand(1, 40, 40)], masks=[mask]), (60, 60), (24, 24))
    assert bool(mask[tuple(where)].all())


def test_an_exemplar_of_single_pixels_is_refused():
    mask = torch.zeros(9, 9, dtype=torch.bool)
    mask[::2, ::2] = True
    with pytest.raises(InputError, match="leaves too little to copy from"):
        run(Exemplar.of([torch.rand(1, 9, 9)], masks=[mask]), (20, 20), (4, 4))


def test_block_size_is_a_share_of_the_exemplar_and_at_most_half_the_output():
    exemplar = Exemplar.of(torch.rand(1, 64, 100))
    assert block_size(exemplar, (300, 300), 0.5, (4, 4)) == (32, 48)
    assert block_size(exemplar, (40, 300), 0.5, (4, 4)) == (20, 48)
    assert block_size(Exemplar.of(torch.rand(1, 3, 3)), (9, 9), 0.5, (4, 4)) == (3, 3)


def test_videos_start_from_blocks_too():
    video = torch.rand(1, 8, 24, 24, generator=torch.Generator().manual_seed(0))
    start, where = run(Exemplar.of(video), (10, 40, 40), (4, 12, 12), (1, 2, 2))
    assert torch.equal(start.x, video[(slice(None), *where)])


def test_blocks_go_where_they_agree_with_a_wish():
    # dark left half, light right half; the wish asks for light above dark
    image = torch.rand(1, 48, 96, generator=torch.Generator().manual_seed(0)) * 0.2
    image[..., 48:] += 0.7
    value = torch.full((1, 96, 60), 0.1)
    value[:, :48] = 0.8
    start, _ = run(Exemplar.of(image), (96, 60), (12, 12), wish=Wish(torch.ones(1, 1, 1).expand_as(value), value))
    assert float(start.x[:, :44].mean()) > 0.75
    assert float(start.x[:, 52:].mean()) < 0.15
    blind, _ = run(Exemplar.of(image), (96, 60), (12, 12))
    assert abs(float(blind.x[:, :44].mean() - blind.x[:, 52:].mean())) < 0.5
