import pytest
import torch

from kwatra import Exemplar
from kwatra.source.canvas import SourceWindows
from kwatra.steps.asked import Asked, Wants
from kwatra.steps.inplace import nearest_in_place
from kwatra.steps.matching import Matching
from kwatra.terms.controls import Given, Wish
from kwatra.windows import Metric, channels_last
from kwatra.windows.grid import Grid


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def blobs(*shape, seed=0):
    noise = torch.rand(1, *(s + 4 for s in shape), generator=generator(seed))
    smooth = torch.nn.functional.avg_pool2d(noise, 5, 1)
    return ((smooth - smooth.amin()) / (smooth.amax() - smooth.amin()))[0][None]


def setting(mask, fixed=None):
    source = SourceWindows(Exemplar.of(blobs(64, 64)), (8, 8), generator())
    grid = Grid((32, 32), (8, 8), (2, 2))
    fixed = torch.zeros(1, 32, 32, dtype=torch.bool) if fixed is None else fixed
    given = Given(fixed | ~mask, torch.zeros(1, 32, 32), mask)
    image = given.held(blobs(32, 32, seed=5))
    return source, grid, Matching(source, grid, given), image, given


def half(share):
    return (torch.arange(32) < 32 * share).expand(1, 32, 32)


def brute_force(source, grid, image, mask):
    """The least masked distance of each window to any exemplar window, and a random one's, where any pixel is there."""
    every, g = source.windows(source.numbers), source.metric.falloff
    rows = []
    for window, present in zip(grid.gather(image), grid.gather(mask.float()), strict=True):
        distance = (g * present * (every - window) ** 2).flatten(1).sum(1) / (g * present).sum().clamp(min=1e-12)
        rows.append(torch.stack([distance.min(), distance.mean()]))
    return torch.stack(rows)


@pytest.mark.parametrize("repeated", [False, True])
def test_masked_windows_find_nearly_the_best_match_of_their_unmasked_pixels(repeated):
    mask = half(0.45)
    source, grid, matching, image, _ = setting(mask)
    found = matching.best(image, None, Wants(), "exact")
    if repeated:
        first, found = found, matching.best(image, found.matches, Wants(), "exact")
        assert bool((found.squared <= first.squared * 1.0001 + 1e-7).all())
    least, usual = brute_force(source, grid, image, mask).T
    partial = grid.gather(mask.float()).flatten(1).mean(1)
    some = (partial > 0) & (partial < 1)
    assert bool((found.squared >= least * 0.999 - 1e-7)[some].all())  # real windows, measured exactly
    gain = (usual - found.squared)[some].sum() / (usual - least)[some].sum()
    assert float(gain) > (0.963 if repeated else 0.95)


def test_windows_without_a_free_pixel_are_skipped():
    fixed = half(0.5)
    source, grid, matching, image, given = setting(torch.ones_like(fixed), fixed)
    before = source.numbers[torch.randint(len(source.numbers), (len(grid),), generator=generator(1))]
    found = matching.best(image, before, Wants(), "exact")
    active = grid.gather(given.free.float()).flatten(1).any(1)
    assert torch.equal(matching.active, active)
    assert torch.equal(found.matches[~active], before[~active])
    assert not bool(found.squared[~active].any())
    assert float((found.matches[active] != before[active]).float().mean()) > 0.9


def test_what_is_not_looked_for_costs_nothing_without_a_match_too():
    mask = torch.ones_like(half(0.5))
    source, grid, matching, image, given = setting(mask, half(0.5))
    matching = Matching(source, grid, Given(given.fixed, given.value, None))
    found = matching.best(image, None, Wants(), "exact")
    assert not bool(found.squared[~matching.active].any())
    assert bool((found.squared[matching.active] > 0).any())


def test_weights_see_only_what_is_free():
    fixed = half(0.5)
    source, grid, matching, image, _ = setting(torch.ones_like(fixed), fixed)
    found = matching.best(image, None, Wants(), "exact")
    free = grid.gather((~fixed).float())
    g = source.metric.falloff
    difference = (free * g * (grid.gather(image) - source.windows(found.matches)) ** 2).flatten(1).sum(1)
    share = (free * g).flatten(1).sum(1)
    assert torch.allclose(found.free, difference / share.clamp(min=1e-12), atol=1e-7)


def test_the_cost_is_equation_26_under_the_falloff_and_its_target_the_minimum():
    source, grid, _, image, _ = setting(half(1.0))
    wish = Wish(torch.full((1, 32, 32), 0.7), blobs(32, 32, seed=9))
    asked = Asked.of(grid, image, Wants(wish), None)
    metric = source.metric
    windows, value = grid.gather(image), grid.gather(wish.value)
    target = asked.target(source, None)
    there = source.windows(source.numbers[: len(grid)])
    cost, squared = asked.cost(metric, there)
    assert torch.allclose(squared, metric.squared(windows - there))
    assert torch.allclose(cost, metric.squared(windows - there) + 0.7 * metric.squared(value - there), atol=1e-6)
    # any window's cost exceeds the target's by 1.7 times its distance to the target
    excess = cost - asked.cost(metric, target)[0]
    assert torch.allclose(excess, 1.7 * metric.squared(there - target), atol=1e-5)


@pytest.mark.parametrize("plain", [True, False])
def test_windows_are_weighed_by_their_free_pixels_in_place_and_copied_out(plain, monkeypatch):
    if not plain:
        monkeypatch.setattr("kwatra.steps.matching.fits", lambda source: False)
    fixed = torch.zeros(1, 32, 32, dtype=torch.bool)
    fixed[..., 13:] = True
    source, grid = SourceWindows(Exemplar.of(blobs(64, 64)), (8, 8), generator()), Grid((32, 32), (8, 8), (2, 2))
    image = blobs(32, 32, seed=5)
    found = Matching(source, grid, Given(fixed, image, None)).best(image, None, Wants(), "exact")
    free, apart = grid.gather((~fixed).float()), grid.gather(image) - source.windows(found.matches)
    active = free.flatten(1).any(1)
    weight = source.metric.weight * free
    expected = (weight * apart.square()).flatten(1).sum(1) / weight.flatten(1).sum(1).clamp(min=1e-12)
    assert 0 < int(active.sum()) < len(grid)
    assert torch.allclose(found.free[active], expected[active], atol=1e-6)
    assert torch.allclose(found.squared[active], source.metric.squared(apart)[active], atol=1e-6)


def test_a_copy_is_left_where_a_term_wants_something_else():
    source, grid = SourceWindows(Exemplar.of(blobs(64, 64)), (8, 8), generator()), Grid((32, 32), (8, 8), (2, 2))
    copied = source.number(grid.corners + 7)
    image = source.exemplar.canvas[:, 7:39, 7:39]
    matching = Matching(source, grid, None)
    assert torch.equal(matching.best(image, copied, Wants(), "exact").matches, copied)
    wish = Wish(torch.full_like(image, 50.0), image.roll(16, 2))
    wanted = matching.best(image, copied, Wants(wish), "exact")
    off = [(source.windows(m) - grid.gather(wish.value)).square().mean() for m in (wanted.matches, copied)]
    assert float(off[0]) < 0.5 * float(off[1])


def test_what_is_wished_for_counts_alike_however_much_of_a_window_is_masked():
    metric, grid = Metric((8, 8), torch.ones(1)), Grid((8, 8), (8, 8), (2, 2))
    for share in (1.0, 0.5, 0.25):
        inside = (torch.arange(8) < 8 * share).expand(1, 8, 8)
        wish = Wish(3.0 * inside, torch.full((1, 8, 8), 0.5))
        asked = Asked.of(grid, torch.zeros(1, 8, 8), Wants(wish), inside)
        cost, squared = asked.cost(metric, torch.full((1, 8, 8, 1), 0.7))
        assert float(squared) == pytest.approx(0.49)
        assert float(cost) == pytest.approx(0.49 + 3 * 0.04)


def test_what_candidates_cost_for_their_places_is_no_distance():
    source, grid = SourceWindows(Exemplar.of(blobs(40, 40)), (8, 8), generator()), Grid((32, 32), (8, 8), (4, 4))
    image = blobs(32, 32, seed=3)
    pick = torch.randint(len(source.numbers), (len(grid), 4), generator=generator(1))
    candidates, away = source.numbers[pick], 0.02 * torch.rand(len(grid), 4, generator=generator(2))
    number, squared = nearest_in_place(channels_last(image), grid.corners, source, candidates, away=away)
    every = torch.stack([source.metric.squared(grid.gather(image) - source.windows(c)) for c in candidates.T], 1)
    best = (every + away).argmin(1, keepdim=True)
    assert bool((best != every.argmin(1, keepdim=True)).any())
    assert torch.equal(number, candidates.gather(1, best)[:, 0])
    assert torch.allclose(squared, every.gather(1, best)[:, 0], atol=1e-6)
