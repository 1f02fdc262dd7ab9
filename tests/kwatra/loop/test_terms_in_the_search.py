"""Terms reach the search: what they charge candidates, what they begin with, and that the index keeps being asked."""

import pytest
import torch

from kwatra import Exemplar, InputError, Level, Quadratic, Settings, SoftPixels, Term, optimize
from kwatra.source import SourceWindows
from kwatra.steps.asked import Wants
from kwatra.steps.matching import DRAWN, Matching
from kwatra.terms import Wish
from kwatra.windows import Grid

LARGE = (256, 256)
"""Of an exemplar of this size an output of 80x80 px is not searched exactly: that would be 8e7 pairs of windows."""


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def noise(*shape, seed=0):
    smooth = torch.nn.functional.avg_pool2d(torch.rand(1, 1, *(s + 4 for s in shape), generator=generator(seed)), 5, 1)
    return ((smooth - smooth.amin()) / (smooth.amax() - smooth.amin()))[0]


class Busy(Term):
    """Windows should hold much variation: charged window by window, for no quadratic of pixels can say it."""

    name = "busy"

    def at(self, factor, shape):
        return self

    def energy(self, x):
        return -float(x.var())

    def quadratic(self, x):
        return Quadratic(torch.zeros_like(x[:1]), torch.zeros_like(x))

    def charge(self, x, step):
        assert step.source.metric.weight.shape[:2] == step.width
        return lambda corners, there: -10 * there.flatten(1).var(1)


def test_a_charge_is_added_to_the_distance_and_decides():
    source = SourceWindows(Exemplar.of(noise(10, 11)), (8, 8), generator())  # 12 windows: as many as are compared
    grid = Grid((24, 24), (8, 8), (4, 4))
    image = noise(24, 24, seed=3)
    seen = []

    def charge(corners, there):
        seen.append(len(corners))
        return 5.0 * (there.flatten(1).mean(1) - corners[:, 0] / 24).square()

    matching = Matching(source, grid, None)
    found = matching.best(image, None, Wants(charges=[charge]), "exact").matches
    windows, every = grid.gather(image), source.windows(source.numbers)
    for k, window in enumerate(windows):
        cost = source.metric.squared(every - window)
        cost = cost + 5.0 * (every.flatten(1).mean(1) - grid.corners[k, 0] / 24).square()
        assert int(found[k]) == int(source.numbers[cost.argmin()])
    assert seen[0] == len(grid)


def test_a_term_that_charges_candidates_gets_its_way():
    flat = torch.where(torch.arange(64) < 32, 0.5, noise(64, 64))
    exemplar = Exemplar.of(flat)
    how = {"settings": Settings(levels=(Level(1, 8, 4),)), "start": "windows"}
    plain = optimize(exemplar, (48, 48), **how).image
    busy = optimize(exemplar, (48, 48), **how, terms=Busy()).image
    assert float(busy.var()) > 2 * float(plain.var())
    scaled = optimize(exemplar, (48, 48), **how, terms=1.0 * Busy()).image
    assert torch.equal(scaled, busy)
    off = optimize(exemplar, (48, 48), **how, terms=0.0 * Busy()).image
    assert float(off.var()) < 0.7 * float(busy.var())


def test_what_a_term_charges_itself_is_not_charged_by_its_quadratic_again():
    class Free(Busy):
        def quadratic(self, x):
            return Quadratic(torch.full_like(x[:1], 5.0), torch.ones_like(x))

        def charge(self, x, step):
            return lambda corners, there: torch.zeros(len(corners))

    exemplar, start = Exemplar.of(noise(10, 11)), noise(32, 32, seed=3)
    settings = Settings(levels=(Level(1, 8, 1),))
    plain = optimize(exemplar, (32, 32), settings=settings, start=start)
    same = optimize(exemplar, (32, 32), settings=settings, start=start, terms=Free())
    assert torch.equal(same.where, plain.where)
    assert float(same.image.mean()) > float(plain.image.mean()) + 0.2  # the blend heeds it


def test_where_terms_want_something_the_index_keeps_being_asked():
    exemplar = Exemplar.of(noise(*LARGE))
    wanted = noise(80, 80, seed=9)
    term = SoftPixels(wanted, torch.full((1, 80, 80), 0.3))
    settings = Settings(levels=(Level(1, 8, 5),))
    rows = optimize(exemplar, (80, 80), settings=settings, terms=term, seed=1).energies
    assert {row["route"] for row in rows} == {"coherent"}
    assert rows[-1]["soft pixels"] < 0.8 * rows[0]["soft pixels"]
    deaf = Settings(levels=(Level(1, 8, 5, route="coherent"),))
    alone = optimize(exemplar, (80, 80), settings=deaf, terms=term, seed=1).energies
    assert rows[-1]["total"] < 0.95 * alone[-1]["total"]


def test_random_windows_are_no_copies_to_go_by():
    exemplar, settings = Exemplar.of(noise(*LARGE)), Settings(levels=(Level(1, 8, 2),))
    for start, route in (("windows", "approximate"), ("aligned", "coherent")):
        rows = optimize(exemplar, (80, 80), settings=settings, start=start).energies
        assert {row["route"] for row in rows} == {route}


def test_a_start_by_the_terms_alone_takes_the_cheapest_candidates_whatever_they_look_like():
    source = SourceWindows(Exemplar.of(noise(40, 40)), (8, 8), generator())
    grid = Grid((24, 24), (8, 8), (4, 4))
    matching = Matching(source, grid, None)
    value = noise(24, 24, seed=4)
    wants = Wants(Wish(torch.ones(1, 24, 24), value), [lambda corners, there: there.flatten(1).mean(1)])
    found = matching.by_terms(wants, torch.zeros(1, 24, 24), generator(1))
    pick = torch.randint(len(source.numbers), (len(grid), DRAWN), generator=generator(1))
    wished, there = grid.gather(value), source.windows(found)
    cost = source.metric.squared(there - wished) + there.flatten(1).mean(1)
    for column in source.numbers[pick].T:
        other = source.windows(column)
        assert bool((cost <= source.metric.squared(other - wished) + other.flatten(1).mean(1) + 1e-6).all())


def test_an_optimization_may_start_by_its_terms():
    exemplar = Exemplar.of(noise(64, 64))
    wanted = torch.linspace(0.2, 0.8, 48).expand(1, 48, 48)
    term = SoftPixels(wanted, torch.full((1, 48, 48), 0.5))
    settings = Settings(levels=(Level(1, 8, 1),))
    by_terms, by_chance = (
        optimize(exemplar, (48, 48), settings=settings, terms=term, start=start).energies[0]["soft pixels"]
        for start in ("terms", "windows")
    )
    assert by_terms < 0.7 * by_chance
    with pytest.raises(InputError, match="the start is 'terms' but there is no term"):
        optimize(exemplar, (48, 48), start="terms")
