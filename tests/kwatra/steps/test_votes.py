import pytest
import torch

from kwatra import Exemplar, InputError, Settings, optimize
from kwatra.source import CHUNK, Bag, SourceWindows
from kwatra.steps import Ballot, Decisive, Mode, blend, mean, winner
from kwatra.steps.votes import bands
from kwatra.windows import FreeWindows, Grid, Metric


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def stacked(values, weights):
    """A ballot of windows of one color each, all lying on one another."""
    width = (4, 4)
    windows = torch.tensor(values).view(-1, 1, 1, 1).expand(-1, *width, 1).contiguous()
    bag = Bag(windows, torch.ones(1), generator())
    layout = FreeWindows(width, width, torch.zeros(len(values), 2, dtype=torch.long))
    return Ballot(layout, bag, torch.arange(len(values)), torch.tensor(weights))


def test_votes_of_windows_on_one_another_are_known():
    ballot = stacked([0.2, 0.22, 0.21, 0.9], [1.0, 1.0, 1.0, 2.5])
    assert torch.allclose(blend(ballot).x, torch.full((1, 4, 4), (0.63 + 2.25) / 5.5))
    assert torch.allclose(blend(ballot, vote=winner).x, torch.full((1, 4, 4), 0.9))
    # three alike outvote one that weighs most, but not one that weighs more than they do together
    assert torch.allclose(blend(ballot, vote=Mode(0.05)).x, torch.full((1, 4, 4), 0.21), atol=2e-3)
    heavy = stacked([0.2, 0.22, 0.21, 0.9], [1.0, 1.0, 1.0, 5.0])
    assert torch.allclose(blend(heavy, vote=Mode(0.05)).x, torch.full((1, 4, 4), 0.9), atol=1e-3)


def test_the_best_window_decides_where_others_say_about_the_same():
    ballot = stacked([0.2, 0.3, 0.8], [1.0, 2.0, 0.5])
    middle = (0.2 + 0.6 + 0.4) / 3.5
    powers = torch.tensor([1.0, 2.0, 0.5], dtype=torch.float64) ** 4
    sharp = float((powers * torch.tensor([0.2, 0.3, 0.8], dtype=torch.float64)).sum() / powers.sum())
    for tolerance in (0.0, 0.05, 1e3):
        heeded = tolerance**2 / (tolerance**2 + (sharp - middle) ** 2)
        found = blend(ballot, vote=Decisive(tolerance)).x
        assert torch.allclose(found, torch.full((1, 4, 4), middle + (sharp - middle) * heeded), atol=1e-5)
    alike = stacked([0.4, 0.4], [1e4, 1e-4])  # of perfect matches and of bad ones
    assert torch.allclose(blend(alike, vote=Decisive(0.0)).x, torch.full((1, 4, 4), 0.4))


def test_the_best_windows_decide_alike_for_any_number_of_threads():
    exemplar = Exemplar.of(torch.rand(6, 40, 40, generator=generator()))
    layout = Grid((402, 406), (4, 4), (1, 1))  # no share of which is whole vectors
    source = SourceWindows(exemplar, (4, 4), generator())
    matches = source.snapped(torch.randint(0, 36, (len(layout), 2), generator=generator(1)))
    weights = 10 ** (6 * torch.rand(len(layout), generator=generator(3)))
    ballot, found = Ballot(layout, source, matches, weights), []
    for count in (1, 2, 3):
        torch.set_num_threads(count)
        found.append(Decisive(0.1)(ballot).value)
    assert all(torch.equal(found[0], other) for other in found)


def test_the_mode_is_where_the_weighted_density_peaks():
    values = torch.rand(12, generator=generator(2)).tolist()
    weights = (torch.rand(12, generator=generator(3)) + 0.1).tolist()
    vote = Mode(0.08, rounds=200)
    found = float(blend(stacked(values, weights), vote=vote).x[0, 0, 0])
    line = torch.linspace(0, 1, 2001, dtype=torch.float64)
    v, w = torch.tensor(values, dtype=torch.float64), torch.tensor(weights, dtype=torch.float64)
    density = (w * torch.exp(-((line[:, None] - v) ** 2) / (2 * 0.08**2))).sum(1)
    peaks = line[1:-1][(density[1:-1] > density[:-2]) & (density[1:-1] > density[2:])]
    assert float((peaks - found).abs().min()) < 2e-3


@pytest.mark.parametrize("threads", [1, 3])
def test_the_mode_of_windows_of_a_bag_is_that_of_tensors(threads):
    grid = Grid((24, 22), (6, 4), (3, 2), wrap=(True, False))
    bag = Bag(torch.rand(50, 6, 4, 3, generator=generator()), torch.tensor([1.0, 2.0, 0.0]), generator())
    matches = torch.randint(50, (len(grid),), generator=generator(1))
    weights = torch.rand(len(grid), generator=generator(2)) + 0.1
    expected = Mode(0.2)(Ballot(grid, bag, matches, weights))  # tensors, as windows on a grid are gone through
    torch.set_num_threads(threads)  # which share the pixels
    layout = FreeWindows(grid.shape, grid.width, grid.corners, grid.wrap)
    value, mass = Mode(0.2)(Ballot(layout, bag, matches, weights))
    assert torch.allclose(mass, expected.mass)
    assert torch.allclose(value, expected.value, atol=1e-5)


def test_what_no_window_covers_has_no_mode():
    bag = Bag(torch.rand(3, 4, 4, 1, generator=generator()), torch.ones(1), generator())
    layout = FreeWindows((12, 12), (4, 4), torch.tensor([[0, 0], [7, 8]]))
    value, mass = Mode()(Ballot(layout, bag, torch.tensor([1, 2]), torch.ones(2)))
    assert torch.equal(mass > 0, mean(Ballot(layout, bag, torch.tensor([1, 2]), torch.ones(2))).mass > 0)
    assert not value[mass == 0].any()


def test_all_votes_give_one_mass_and_agree_where_windows_do():
    exemplar = Exemplar.of(torch.rand(2, 24, 24, generator=generator()))
    source = SourceWindows(exemplar, (8, 8), generator())
    grid = Grid((20, 20), (8, 8), (2, 2))
    matches = source.snapped(grid.corners + 3)
    ballot = Ballot(grid, source, matches, torch.rand(len(grid), generator=generator(1)) + 0.1)
    expected = exemplar.canvas[:, 3:23, 3:23]
    for vote in (mean, winner, Mode(), Decisive(0.1)):
        value, mass = vote(ballot)
        assert torch.allclose(value, expected, atol=1e-5)
        assert torch.allclose(mass, mean(ballot).mass)


@pytest.mark.parametrize("vote", [winner, Mode()])
def test_an_optimization_by_another_vote_lowers_its_energy(vote):
    exemplar = Exemplar.of(torch.nn.functional.avg_pool2d(torch.rand(1, 44, 44, generator=generator()), 5, 1))
    result = optimize(exemplar, (40, 40), settings=Settings(vote=vote), start="windows")
    last = [row["total"] for row in result.energies if row["level"] == result.energies[-1]["level"]]
    assert last[-1] < last[0]
    if vote is winner:  # every pixel is some pixel of the exemplar, which means are not
        assert apart(result.image, exemplar) < 1e-6
        assert apart(optimize(exemplar, (40, 40), start="windows").image, exemplar) > 1e-5


def apart(image, exemplar):
    """The largest distance of a pixel's value to the nearest value of the exemplar."""
    return float((image.flatten()[:, None] - exemplar.canvas.flatten()).abs().amin(1).max())


def test_a_mode_without_a_width_is_refused():
    with pytest.raises(InputError, match="no bandwidth above 0"):
        Mode(0.0)
    with pytest.raises(InputError, match="not finite or below 0"):
        Decisive(-0.1)


def test_a_pass_over_windows_holds_few_of_them_at_a_time():
    width = (8, 8)
    grid = Grid((400, 300), width, (2, 2))
    metric = Metric(width, torch.ones(3))
    parts = bands(grid, metric)
    assert [part.start for part, _ in parts[1:]] == [part.stop for part, _ in parts[:-1]]
    assert (parts[0][0].start, parts[-1][0].stop) == (0, len(grid))
    assert len(parts) > 1
    assert all(part.stop - part.start == len(band) for part, band in parts)
    assert max(len(band) for _, band in parts) * metric.weight.numel() <= CHUNK


def test_a_mode_counts_every_window_once_where_few_cover_a_pixel():
    width, grid = (4, 4), Grid((11, 13), (4, 4), (2, 2))
    bag = Bag(torch.rand(20, *width, 3, generator=generator(1)), torch.ones(3), generator())
    matches = torch.randint(20, (len(grid),), generator=generator(2))
    weights = torch.rand(len(grid), generator=generator(3))
    one, same = (
        Mode(0.2)(Ballot(layout, bag, matches, weights))
        for layout in (grid, FreeWindows(grid.shape, width, grid.corners))
    )
    assert torch.allclose(one.mass, same.mass, atol=1e-6)
    assert torch.allclose(one.value, same.value, atol=1e-4)
