import pytest
import torch

from kwatra import Exemplar, FreeWindows, Grid
from kwatra.source import Bag, SourceWindows
from kwatra.steps.asked import Wants
from kwatra.steps.inplace import fits, means_in_place, nearest_in_place
from kwatra.steps.matching import Matching
from kwatra.windows import channels_last
from kwatra.windows.flat import continued


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def settings():
    yield (2, 30, 34), (8, 6), Grid((21, 26), (8, 6), (4, 3))
    yield (2, 30, 34), (8, 6), Grid((21, 26), (8, 6), (4, 3), wrap=True)
    yield (3, 30, 34), (8, 6), FreeWindows((21, 26), (8, 6), torch.tensor([[13, 20], [0, 0], [5, 7], [5, 7]]))
    yield (1, 6, 14, 13), (4, 4, 4), Grid((5, 12, 9), (4, 4, 4), (1, 2, 2))
    yield (1, 6, 14, 13), (4, 4, 4), Grid((5, 12, 9), (4, 4, 4), (1, 2, 2), wrap=True)


@pytest.fixture(params=settings(), ids=["grid", "wrapped", "free", "volume", "wrapped volume"])
def setting(request):
    shape, width, layout = request.param
    source = SourceWindows(Exemplar.of(torch.rand(shape, generator=generator())), width, generator())
    candidates = source.numbers[torch.randint(len(source.numbers), (len(layout), 5), generator=generator(1))]
    candidates[:, 3] = candidates[:, 1]
    image = torch.rand(shape[0], *layout.shape, generator=generator(2))
    return source, layout, candidates, image


def test_the_nearest_candidate_is_that_of_brute_force(setting):
    source, layout, candidates, image = setting
    pixels = continued(channels_last(image), layout)
    windows = layout.gather(image)
    every = torch.stack([source.metric.squared(windows - source.windows(column)) for column in candidates.T], 1)
    number, squared = nearest_in_place(pixels, layout.corners, source, candidates)
    assert torch.equal(number, candidates.gather(1, every.argmin(1, keepdim=True))[:, 0])
    assert torch.allclose(squared, every.amin(1), atol=1e-6)
    lax, _ = nearest_in_place(pixels, layout.corners, source, candidates, settled=1e9)
    assert torch.equal(lax, candidates[:, 0])


@pytest.mark.parametrize("band", [1, 400, 1 << 18])
def test_means_are_those_of_the_windows_copied_out(setting, band, monkeypatch):
    monkeypatch.setattr("kwatra.steps.inplace.BAND", band)
    source, layout, candidates, _ = setting
    weights = torch.rand(len(layout), generator=generator(3)) + 0.1
    value, mass = means_in_place(layout, source, candidates[:, 0], weights)
    weight = weights.view(-1, *[1] * (len(layout.shape) + 1)) * source.metric.falloff
    assert torch.allclose(value * mass, layout.scatter(weight * source.windows(candidates[:, 0])), atol=1e-6)
    assert torch.allclose(mass, layout.scatter(weight), atol=1e-6)
    assert not value[:, mass[0] == 0].any()


def test_the_same_bits_for_any_number_of_threads():
    source = SourceWindows(Exemplar.of(torch.rand(3, 40, 40, generator=generator())), (8, 8), generator())
    grid = Grid((300, 80), (8, 8), (2, 2))
    candidates = source.numbers[torch.randint(len(source.numbers), (len(grid), 3), generator=generator(1))]
    pixels = channels_last(torch.rand(3, 300, 80, generator=generator(2)))
    weights = torch.rand(len(grid), generator=generator(3))
    results = []
    for count in (1, 2, 3):
        torch.set_num_threads(count)
        found = nearest_in_place(pixels, grid.corners, source, candidates)
        results.append([*found, *means_in_place(grid, source, found[0], weights)])
    assert all(torch.equal(a, b) for other in results[1:] for a, b in zip(results[0], other, strict=True))


@pytest.mark.parametrize("route", ["exact", "coherent"])
def test_a_search_in_place_is_never_worse_than_one_of_windows_copied_out(route, monkeypatch):
    smooth = torch.nn.functional.avg_pool2d(torch.rand(3, 68, 68, generator=generator()), 5, 1)
    source = SourceWindows(Exemplar.of(smooth), (8, 8), generator())
    grid = Grid((48, 48), (8, 8), (2, 2))
    image = torch.nn.functional.avg_pool2d(torch.rand(3, 52, 52, generator=generator(4)), 5, 1)
    before = source.snapped(grid.corners + 2)
    found = Matching(source, grid, None).best(image, before, Wants(), route)
    monkeypatch.setattr("kwatra.steps.matching.fits", lambda source: False)
    copied_out = Matching(source, grid, None).best(image, before, Wants(), route)
    assert float((found.squared - copied_out.squared).mean()) <= 1e-7
    assert torch.allclose(
        found.squared, source.metric.squared(grid.gather(image) - source.windows(found.matches)), atol=1e-6
    )


def far(corners, there):
    """A charge for places that are far from where a window lies."""
    return 1e-3 * (there - corners[:, None]).abs().sum(-1).float()


@pytest.mark.parametrize("wants", [Wants(), Wants(places=[far])], ids=["nothing", "places"])
@pytest.mark.parametrize("threads", [1, 2])
def test_a_coherent_search_in_parts_is_one_of_the_whole(threads, wants, monkeypatch):
    source = SourceWindows(Exemplar.of(torch.rand(3, 40, 40, generator=generator())), (8, 8), generator())
    grid = Grid((60, 48), (8, 8), (2, 2), wrap=(True, False))
    image, before = torch.rand(3, 60, 48, generator=generator(2)), source.snapped(grid.corners % 30)
    matching = Matching(source, grid, None)
    whole = matching.best(image, before, wants, "coherent")
    monkeypatch.setattr("kwatra.steps.matching.TOGETHER", 37)
    torch.set_num_threads(threads)
    parts = matching.best(image, before, wants, "coherent")
    assert not torch.equal(whole.matches, before)
    assert torch.equal(parts.matches, whole.matches)
    assert torch.equal(parts.squared, whole.squared)


def test_only_windows_of_a_canvas_are_worked_on_in_place():
    assert not fits(Bag(torch.rand(4, 8, 8, 3, generator=generator()), torch.ones(3), generator()))
