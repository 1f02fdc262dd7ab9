import pytest
import torch

from kwatra import Exemplar, Feature, InputError, gradient
from kwatra.source.canvas import SourceWindows
from kwatra.source.closest import closest
from kwatra.source.components import random_probe, randomized_basis
from kwatra.steps.matching import cheapest
from kwatra.windows.grid import Grid


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def blobs(*shape, seed=0, size=5):
    """Smooth noise: neighborhoods vary slowly, as in a texture."""
    noise = torch.rand(1, *shape, generator=generator(seed))
    smooth = torch.nn.functional.avg_pool2d(noise, size, 1, size // 2, count_include_pad=False)
    return ((smooth - smooth.amin()) / (smooth.amax() - smooth.amin()))[0]


def source_of(image, width=(8, 8), **options):
    return SourceWindows(Exemplar.of(image), width, generator(1), **options)


def all_windows(source):
    return source.windows(source.numbers)


def distances(source, windows, there):
    squared = source.metric.squared(windows - there)
    return squared, squared


def brute_force(source, windows):
    return torch.stack([source.metric.squared(all_windows(source) - w) for w in windows])


def test_where_faiss_does_not_reach_all_points_are_compared(monkeypatch):
    points, wanted = torch.rand(200, 5, generator=generator(0)), torch.rand(30, 5, generator=generator(1))
    monkeypatch.setattr("kwatra.source.closest.chunk", lambda device: 7 * len(points))
    expected = torch.cdist(wanted, points).argsort(1)
    assert closest(points, wanted, 4).equal(expected[:, :4])
    assert closest(points[:3], wanted, 4).equal(torch.cdist(wanted, points[:3]).argsort(1))


@pytest.mark.parametrize("features", [(), (Feature(gradient, 1.0),)])
def test_estimates_with_every_component_are_exact(features):
    source = source_of(blobs(3, 20, 22), (4, 4), dims=200, features=features)
    windows = torch.rand(6, 4, 4, 3, generator=generator())
    estimated = source.estimate(source.describe(windows), source.numbers.expand(6, -1))
    assert torch.allclose(estimated, brute_force(source, windows), atol=1e-4)


@pytest.mark.parametrize("features", [(), (Feature(gradient, 1.0),)])
@pytest.mark.parametrize(("shape", "width"), [((41, 23), (4, 4)), ((12, 14, 15), (2, 4, 4))])
def test_windows_described_some_at_a_time_are_described_the_same(features, shape, width, monkeypatch):
    image = torch.rand(2, *shape, generator=generator())
    together = source_of(image, width, features=features)
    monkeypatch.setattr("kwatra.source.canvas.TOGETHER", 1)
    monkeypatch.setattr("kwatra.source.canvas.OVERLAPS", 1)
    parts = source_of(image, width, features=features)
    assert parts.count == together.count == len(parts.descriptors)
    assert torch.allclose(parts.descriptors, together.descriptors, atol=1e-6)
    assert torch.allclose(parts.remainder, together.remainder, atol=1e-3)


def test_what_descriptors_leave_out_counts_by_its_length():
    source = source_of(blobs(1, 24, 24), (6, 6), dims=2)
    described = source.describe(torch.rand(3, 6, 6, 1, generator=generator()))
    numbers = source.numbers[[7, 50]].expand(3, -1)
    between = (source.descriptors[numbers] - described.descriptor[:, None]).square().sum(-1)
    left = (source.remainder[numbers] - described.remainder[:, None]).square()
    assert float(left.min()) > 0
    assert torch.allclose(source.estimate(described, numbers), between + left)
    own = source.describe(source.windows(source.numbers[[7, 50]]))
    assert torch.allclose(source.estimate(own, source.numbers[[7, 50], None])[:, 0], torch.zeros(2), atol=1e-6)


def test_where_lists_hold_fewer_than_are_asked_for_the_nearest_is_named_again():
    source = source_of(blobs(1, 44, 44), (4, 4))
    found = source.nearest(source.describe(source.windows(source.numbers[:5])), 1500, "approximate")
    assert bool(torch.isin(found, source.numbers).all())
    assert bool((found[:, -1] == found[:, 0]).all())


def test_of_a_tiny_exemplar_the_approximate_route_finds_the_nearest_and_prints_nothing(capfd):
    source = source_of(blobs(1, 12, 12))
    assert len(source.numbers) < 39
    described = source.describe(source.windows(source.numbers))
    assert torch.equal(source.nearest(described, 1, "approximate")[:, 0], source.numbers)
    assert capfd.readouterr() == ("", "")


def test_exact_route_finds_the_nearest_window():
    image = blobs(3, 40, 40)
    source = source_of(image)
    windows = Grid((40, 40), (8, 8), (4, 4)).gather(blobs(3, 40, 40, seed=5))
    found = source.nearest(source.describe(windows), 3, "exact")
    _, squared = cheapest(source, found, lambda there: distances(source, windows, there))
    best = brute_force(source, windows).amin(1)
    assert float((squared / best - 1).mean()) < 0.02
    assert bool((squared >= best * (1 - 1e-4)).all())


def test_a_window_of_the_exemplar_finds_itself_on_every_route():
    source = source_of(blobs(3, 64, 64))
    pick = source.numbers[::37]
    windows = source.windows(pick)
    for route in ("exact", "approximate"):
        found = source.nearest(source.describe(windows), 1, route)[:, 0]
        assert float((found == pick).float().mean()) > 0.99, route


def test_projected_windows_are_those_described_but_for_the_remainder():
    source = source_of(blobs(3, 40, 44))
    windows = torch.rand(6, 8, 8, 3, generator=generator())
    projected = source.projected(windows)
    assert torch.allclose(projected.descriptor, source.describe(windows).descriptor, atol=1e-5)
    assert not projected.remainder.any()


def test_the_approximate_route_keeps_97_percent_of_the_gain():
    # gain: how far a search lowers the mean distance below that of an arbitrary match
    source = source_of(blobs(3, 128, 128, size=7))
    windows = Grid((128, 128), (8, 8), (4, 4)).gather(blobs(3, 128, 128, seed=9, size=7))
    described = source.describe(windows)
    means = {}
    for route in ("exact", "approximate"):
        found = source.nearest(described, 3, route)
        means[route] = float(cheapest(source, found, lambda there: distances(source, windows, there))[1].mean())
    pick = torch.randint(len(source.numbers), (len(windows),), generator=generator())
    anything = float(source.metric.squared(windows - source.windows(source.numbers[pick])).mean())
    assert (anything - means["approximate"]) / (anything - means["exact"]) > 0.97
    assert means["approximate"] > 0.9 * means["exact"]


def test_cheapest_is_the_brute_force_minimum_and_keeps_the_first_of_equals():
    source = source_of(blobs(1, 24, 24), (4, 4))
    windows = torch.rand(10, 4, 4, 1, generator=generator())
    candidates = source.numbers[torch.randint(len(source.numbers), (10, 5), generator=generator())]
    candidates[:, 4] = candidates[:, 1]

    def cost(there):
        squared = source.metric.squared(windows - there)
        return squared + there.flatten(1).mean(1), squared

    number, squared = cheapest(source, candidates, cost)
    every = torch.stack([cost(source.windows(c))[0] for c in candidates.T])
    assert torch.equal(number, candidates[torch.arange(10), every.argmin(0)])
    assert torch.allclose(squared, source.metric.squared(windows - source.windows(number)))


def test_snapping_goes_to_the_nearest_usable_window():
    mask = torch.ones(30, 30, dtype=torch.bool)
    mask[10:12, 10:12] = False
    source = SourceWindows(Exemplar.of([blobs(1, 30, 30)], masks=[mask]), (4, 4), generator())
    asked = torch.tensor([[-5, 3], [29, 29], [9, 2], [10, 7]])
    corners = source.corners(source.snapped(asked))
    assert corners[:3].tolist() == [[0, 3], [26, 26], [9, 2]]
    assert corners[3].tolist() == [10, 6]
    assert set(source.snapped(asked).tolist()) <= set(source.numbers.tolist())


def test_masked_pixels_cannot_change_the_search():
    mask = torch.ones(30, 30, dtype=torch.bool)
    mask[5:9, 20:26] = False
    image = blobs(1, 30, 30)
    other = image.clone()
    other[:, 5:9, 20:26] = 7.0
    windows = torch.rand(20, 6, 6, 1, generator=generator())
    found = []
    for each in (image, other):
        source = SourceWindows(Exemplar.of([each], masks=[mask]), (6, 6), generator())
        found.append(source.nearest(source.describe(windows), 2, "exact"))
    assert torch.equal(*found)


def test_randomized_basis_spans_the_leading_singular_vectors():
    rows = torch.randn(300, 40, generator=generator()) * torch.logspace(0, -2, 40)
    basis = randomized_basis(rows, 6, random_probe(tuple(rows.shape), 6, generator()))
    exact = torch.linalg.svd(rows, full_matrices=False).Vh[:6].T
    assert torch.allclose(basis.T @ basis, torch.eye(6), atol=1e-4)
    assert float((exact.T @ basis).square().sum()) == pytest.approx(6, abs=0.05)


def test_an_exemplar_smaller_than_the_window_is_refused():
    with pytest.raises(InputError, match="no 8x8 window fits into the exemplar"):
        source_of(blobs(1, 7, 20))


def test_volumes_are_searched_by_the_same_code():
    volume = torch.rand(2, 6, 12, 12, generator=generator())
    source = SourceWindows(Exemplar.of(volume), (4, 4, 4), generator(), dims=64)
    pick = source.numbers[::11]
    assert torch.equal(source.nearest(source.describe(source.windows(pick)), 1, "exact")[:, 0], pick)
    whole = SourceWindows(Exemplar.of(volume), (4, 4, 4), generator(), dims=128)
    windows = torch.rand(20, 4, 4, 4, 2, generator=generator(3))
    found = whole.nearest(whole.describe(windows), 1, "exact")[:, 0]
    assert torch.equal(found, whole.numbers[brute_force(whole, windows).argmin(1)])


def test_missing_pixels_are_completed_by_what_the_others_imply():
    # windows of a sum of two waves lie in a plane of few dimensions: half of one tells the rest
    y, x = torch.meshgrid(torch.arange(40.0), torch.arange(40.0), indexing="ij")
    image = (0.5 + 0.2 * torch.sin(x * 0.7 + 0.3 * y) + 0.2 * torch.cos(0.5 * y))[None]
    source = source_of(image)
    windows = source.windows(source.numbers[::50])
    present = torch.zeros(len(windows), 8, 8, 1)
    present[:, :, :5] = 1
    completed = source.completed(torch.where(present > 0, windows, torch.nan).nan_to_num(7.0), present)
    assert torch.equal(completed[:, :, :5], windows[:, :, :5])
    assert float((completed - windows).abs().max()) < 0.05
    assert torch.allclose(source.completed(windows, torch.ones_like(present)), windows)
