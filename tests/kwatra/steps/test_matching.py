import pytest
import torch

from kwatra import Exemplar
from kwatra.source.canvas import SourceWindows
from kwatra.steps.asked import Asked, Wants
from kwatra.steps.matching import Matching
from kwatra.terms.controls import Given, Wish
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
