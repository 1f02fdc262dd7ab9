"""Shifted windows: the energy never rises, a known shift is undone, and sums are what brute force gives."""

from itertools import pairwise

import torch

from kwatra import Ballot, FreeWindows, mean
from kwatra.source import Bag
from synth.metamorphosis.patches.relaxation import Relaxed, relaxed

WIDTH = 9


def picture(seed: int, shape: tuple[int, int] = (40, 44)) -> torch.Tensor:
    noise = torch.rand(1, 2, *shape, generator=torch.Generator().manual_seed(seed))
    return torch.nn.functional.avg_pool2d(noise, 5, 1, 2)[0] * 3


def cut(image: torch.Tensor, corners: torch.Tensor) -> torch.Tensor:
    return torch.stack([image[:, y : y + WIDTH, x : x + WIDTH].permute(1, 2, 0) for y, x in corners.tolist()])


def ballot(shift: torch.Tensor, wrap: bool = False) -> tuple[Ballot, torch.Tensor]:
    """Windows of one picture, each pasted `shift` (N, 2) away from its place, and where they belong."""
    image = picture(0)
    rows, columns = torch.arange(4, 40 - WIDTH - 3, 4), torch.arange(4, 44 - WIDTH - 3, 4)
    true = torch.cartesian_prod(rows, columns)
    bag = Bag(cut(image, true), torch.ones(2), torch.Generator().manual_seed(0))
    layout = FreeWindows((40, 44), (WIDTH, WIDTH), true + shift[: len(true)], wrap)
    return Ballot(layout, bag, bag.numbers, torch.ones(len(true))), true


def brute(made: Ballot, layout: FreeWindows, stiffness: float, pairs: set[tuple[int, int]]) -> float:
    """E of the module, written out."""
    weight = made.source.metric.falloff[..., 0].double()
    values = made.source.windows(made.matches).double() * made.source.metric.share.sqrt()
    mass, total, energy = torch.zeros(40, 44).double(), torch.zeros(40, 44, 2).double(), 0.0
    for window, (y, x) in zip(values, layout.corners.tolist(), strict=True):
        mass[y : y + WIDTH, x : x + WIDTH] += weight
        total[y : y + WIDTH, x : x + WIDTH] += weight[..., None] * window
    middle = total / mass.clamp(min=1e-12)[..., None]
    for window, (y, x) in zip(values, layout.corners.tolist(), strict=True):
        apart = (window - middle[y : y + WIDTH, x : x + WIDTH]).square().sum(2)
        energy += float((weight * apart).sum())
    shift = (layout.corners - made.layout.corners).double()
    return energy + stiffness * sum(float((shift[p] - shift[q]).square().sum()) for p, q in pairs)


def springs(layout: FreeWindows) -> set[tuple[int, int]]:
    found = set()
    for number, _ in layout.neighbor_shifts():
        found |= {(min(p, q), max(p, q)) for p, q in enumerate(number.tolist()) if p != q}
    return found


def test_the_energy_never_rises_and_is_what_it_says() -> None:
    generator = torch.Generator().manual_seed(1)
    made, _ = ballot(torch.randint(-2, 3, (200, 2), generator=generator))
    layout, energies = relaxed(made, 2, 0.004, 4)
    assert all(after <= before * (1 + 1e-5) for before, after in pairwise(energies))
    assert energies[-1] < 0.95 * energies[0]
    pairs = springs(made.layout)
    assert abs(energies[0] - brute(made, made.layout, 0.001, pairs)) < 1e-4 * energies[0]
    assert abs(energies[-1] - brute(made, layout, 0.001, pairs)) < 1e-3 * energies[0]


def test_a_window_out_of_place_goes_back() -> None:
    shift = torch.zeros(200, 2, dtype=torch.long)
    shift[20] = torch.tensor([1, -2])
    made, true = ballot(shift)
    layout, energies = relaxed(made, 2, 1e-6, 3)
    assert torch.equal(layout.corners, true)
    assert energies[-1] < 1e-3 * energies[0]


def test_windows_that_agree_stay() -> None:
    made, true = ballot(torch.zeros(200, 2, dtype=torch.long))
    layout, energies = relaxed(made, 2, 0.001, 3)
    assert torch.equal(layout.corners, true)
    assert len(energies) == 2


def test_stiff_springs_hold_windows() -> None:
    generator = torch.Generator().manual_seed(1)
    made, _ = ballot(torch.randint(-1, 2, (200, 2), generator=generator))
    layout, _ = relaxed(made, 2, 1e4, 2)
    assert torch.equal(layout.corners, made.layout.corners)


def test_the_vote_is_taken_where_windows_went() -> None:
    shift = torch.zeros(200, 2, dtype=torch.long)
    shift[20] = torch.tensor([1, -2])
    made, _ = ballot(shift)
    pull = Relaxed(mean, 2, 1e-6)(made)
    shown = pull.value
    there = pull.mass[0] > 0
    assert float((shown - picture(0))[:, there].abs().max()) < 1e-4
