"""The flow energy of a video against its definition, written down spring by spring; candidates against brute force."""

import math
from itertools import product

import pytest
import torch
from torch import Tensor

import flow
from flow.volume import VolumeFlow
from flow.volume.springs import coarser
from kwatra import Exemplar, InputError, Level, Settings, optimize
from kwatra.base import conjugate_gradients
from kwatra.source import SourceWindows
from kwatra.steps.asked import Wants
from kwatra.steps.matching import Matching
from kwatra.windows import Grid

SHAPE = (4, 6, 7)


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def video(channels: int = 2, seed: int = 1) -> Tensor:
    return torch.rand(channels, *SHAPE, generator=generator(seed))


def holes() -> Tensor:
    return torch.rand(SHAPE, generator=generator(5)) > 0.08


def term(loop: bool = False, wrap: bool = False, masked: bool = False, weight: float = 0.7) -> VolumeFlow:
    flows = 1.5 * torch.randn(SHAPE[0] - (not loop), 2, *SHAPE[1:], generator=generator(2))
    flows[1] = flows[1].round()
    return VolumeFlow(flows, weight, loop, wrap, holes() if masked else None)


WAYS = [(False, False, False), (True, False, False), (False, True, False), (True, True, True), (False, False, True)]
every_way = pytest.mark.parametrize(("loop", "wrap", "masked"), WAYS)


def springs(made: VolumeFlow) -> list[dict[int, float]]:
    """Rows of S as {pixel: entry}, from equation 29: x(p, i) - x(q, i + 1), q = p + f_i(p), read bilinearly."""
    frames, height, width = SHAPE
    mask = torch.ones(SHAPE, dtype=torch.bool) if made.mask is None else made.mask
    rows = []
    for i, y, x in product(range(len(made.flows)), range(height), range(width)):
        after, row = (i + 1) % frames, {(i * height + y) * width + x: 1.0}
        to_x, to_y = x + float(made.flows[i, 0, y, x]), y + float(made.flows[i, 1, y, x])
        seen = bool(mask[i, y, x])
        for down, across in product((0, 1), (0, 1)):
            there = math.floor(to_y) + down, math.floor(to_x) + across
            entry = (1 - abs(to_y - there[0])) * (1 - abs(to_x - there[1]))
            if entry == 0:
                continue
            if made.wrap:
                there = there[0] % height, there[1] % width
            elif not (0 <= there[0] < height and 0 <= there[1] < width):
                seen = False
                break
            seen = seen and bool(mask[after, there[0], there[1]])
            pixel = (after * height + there[0]) * width + there[1]
            row[pixel] = row.get(pixel, 0.0) - entry
        if seen:
            rows.append(row)
    return rows


def dense(made: VolumeFlow) -> Tensor:
    """F = S^T S, times the weight, in double precision."""
    rows = springs(made)
    matrix = torch.zeros(len(rows), math.prod(SHAPE), dtype=torch.float64)
    for number, row in enumerate(rows):
        for pixel, entry in row.items():
            matrix[number, pixel] = entry
    return made.weight * matrix.T @ matrix


@every_way
def test_the_operator_is_that_of_equation_29(loop: bool, wrap: bool, masked: bool) -> None:
    made, x = term(loop, wrap, masked), video()
    matrix, quadratic = dense(made), made.quadratic(video())
    flat = x.double().flatten(1)
    assert float(matrix.count_nonzero()) > 3 * len(matrix)
    assert torch.allclose(quadratic.times(x).double().flatten(1), flat @ matrix, atol=1e-5)
    assert torch.allclose(quadratic.diagonal.double().flatten(), matrix.diagonal(), atol=1e-5)
    assert made.energy(x) == pytest.approx(float((flat @ matrix * flat).mean()), rel=1e-5)


@every_way
def test_the_operator_is_symmetric_and_positive(loop: bool, wrap: bool, masked: bool) -> None:
    quadratic, x, y = term(loop, wrap, masked).quadratic(video()), video(seed=3) - 0.5, video(seed=4) - 0.5
    assert float((quadratic.times(x) * y).sum()) == pytest.approx(float((x * quadratic.times(y)).sum()), rel=1e-4)
    assert float((quadratic.times(x) * x).sum()) > 0


def moved(picture: Tensor, step: tuple[int, int], frames: int) -> Tensor:
    """A video (C, T, H, W) of a periodic picture that moves by whole pixels (x, y) a frame."""
    return torch.stack([picture.roll((step[1] * t, step[0] * t), (1, 2)) for t in range(frames)], 1)


def test_what_moves_with_the_flow_costs_nothing_and_anything_else_does() -> None:
    flows = flow.uniform(2.0)(0.0, (8, 8))[None].expand(4, -1, -1, -1)
    x = moved(torch.rand(1, 8, 8, generator=generator()), (2, 0), 4)
    for loop, wrap in ((False, False), (False, True), (True, True)):
        around = VolumeFlow(flows if loop else flows[:3], 1.0, loop, wrap)
        assert around.energy(x) == 0
        assert around.energy(x.flip(1)) > 0.01
    assert VolumeFlow(flows[:3]).energy(x.roll(3, 3)) == 0  # what leaves and enters is free


@every_way
def test_conjugate_gradients_solve_it_as_a_direct_solution_does(loop: bool, wrap: bool, masked: bool) -> None:
    made, right = term(loop, wrap, masked, weight=50.0), video()
    quadratic = made.quadratic(right)
    found = conjugate_gradients(
        lambda v: v + quadratic.times(v), right, 1 + quadratic.diagonal.expand_as(right), torch.zeros_like(right), 1e-5
    )
    assert found.residual <= 1e-5
    matrix = dense(made) + torch.eye(math.prod(SHAPE), dtype=torch.float64)
    direct = torch.linalg.solve(matrix, right.double().flatten(1).T).T
    assert torch.allclose(found.x.flatten(1).double(), direct, atol=1e-3)


def test_what_is_behind_the_mask_has_no_influence() -> None:
    made, x = term().within(holes()), video()
    spoiled = torch.where(holes(), x, 100.0)
    assert made.energy(spoiled) == made.energy(x)
    assert torch.equal(made.quadratic(x).times(spoiled), made.quadratic(x).times(x))
    nothing = made.within(torch.zeros(SHAPE, dtype=torch.bool))
    assert nothing.energy(x) == 0


def test_coarser_levels_see_the_same_motion_in_their_pixels() -> None:
    flows = flow.uniform(4.0)(0.0, (16, 24))[None].expand(3, -1, -1, -1)
    x = moved(torch.rand(2, 16, 24, generator=generator()), (4, 0), 4)
    small = torch.nn.functional.avg_pool2d(x.transpose(0, 1), 2).transpose(0, 1)
    coarse = VolumeFlow(flows).at((1, 2, 2), (4, 8, 12))
    assert coarse.energy(small) == pytest.approx(0, abs=1e-12)
    assert coarse.energy(small.flip(1)) > 1e-3
    turning = flow.rotation(3.0)(0.0, (18, 25))[None]
    halved = VolumeFlow(turning).at((1, 4, 4), (2, 5, 7)).flows[0]
    assert torch.allclose(halved[:, 2, 3], turning[0, :, 8:12, 12:16].mean((1, 2)) / 4, atol=1e-6)


def test_motion_behind_the_mask_is_not_mixed_into_coarser_levels() -> None:
    mask = torch.ones(3, 8, 8, dtype=torch.bool)
    mask[:, 3:6, 3:6] = False
    flows = torch.where(mask[:2, None], torch.ones(2, 2, 8, 8), 900.0)
    coarse = VolumeFlow(flows).within(mask).at((1, 2, 2), (3, 4, 4))
    assert coarse.mask is not None
    assert torch.equal(coarse.mask, torch.nn.functional.max_pool2d(mask.float(), 2) > 0)
    assert torch.allclose(coarse.flows[:, :, coarse.mask[0]], torch.tensor(0.5))


def windows_at(x: Tensor, corners: Tensor, width: tuple[int, ...]) -> tuple[Tensor, ...]:
    axes = [(torch.arange(w) + c) for w, c in zip(width, corners.tolist(), strict=True)]
    return torch.meshgrid(*(a % s for a, s in zip(axes, SHAPE, strict=True)), indexing="ij")


WINDOWS = [(2, 3, 3), (3, 2, 5), (1, 4, 2), (4, 3, 4), (4, 6, 7), (2, 6, 3)]


def corners_of(width: tuple[int, ...], loop: bool, wrap: bool) -> Tensor:
    """Some corners of windows: over the border on axes that are periodic."""
    ends = [s - 1 if periodic else s - w for s, w, periodic in zip(SHAPE, width, (loop, wrap, wrap), strict=True)]
    every = torch.tensor(list(product(*(range(end + 1) for end in ends))))
    return every[torch.randperm(len(every), generator=generator(6))[:9]]


@every_way
@pytest.mark.parametrize("width", WINDOWS)
def test_a_candidate_is_charged_what_it_does_to_the_energy(
    loop: bool, wrap: bool, masked: bool, width: tuple[int, ...]
) -> None:
    """Equation 31: lambda U_c(y) with y the video with the window in its place, up to what all candidates share."""
    made, x, corners = term(loop, wrap, masked), video(), corners_of(width, loop, wrap)
    windows = torch.rand(len(corners), *width, 2, generator=generator(7))
    charge = made.charge(x)
    assert torch.allclose(charge(corners.flip(0), windows.flip(0)).flip(0), charge(corners, windows), atol=1e-6)
    charged = charge(corners, windows)
    matrix, numel = dense(made), windows[0].numel()
    before = energy_of(x, matrix)
    for corner, window, cost in zip(corners, windows, charged, strict=True):
        y = x.double()
        y[(slice(None), *windows_at(x, corner, width))] = window.double().movedim(-1, 0)
        assert float(cost) == pytest.approx((energy_of(y, matrix) - before) / numel, abs=1e-5)


@every_way
def test_the_search_of_equation_31_finds_what_an_exhaustive_one_finds(loop: bool, wrap: bool, masked: bool) -> None:
    """Of all windows z of the clip the least |x_p - z|^2 + lambda U_c(y), y the video with z in the place of x_p."""
    width, made, x = (2, 3, 3), term(loop, wrap, masked, weight=2.0), video()
    source = SourceWindows(Exemplar.of(torch.rand(2, 3, 4, 5, generator=generator(8))), width, generator())
    assert len(source.numbers) == 12  # as many as are compared: 2 x 2 x 3 places
    grid = Grid(SHAPE, width, (1, 1, 1), wrap)
    matching = Matching(source, grid, None)
    found = matching.best(x, None, Wants(charges=[made.charge(x)]), "exact").matches
    matrix, every, by_likeness = dense(made), source.windows(source.numbers), 0
    before = energy_of(x, matrix)
    for k, (corner, window) in enumerate(zip(grid.corners, grid.gather(x), strict=True)):
        unlike = source.metric.squared(every - window)
        cost = unlike.double()
        for n, candidate in enumerate(every):
            y = x.clone()
            y[(slice(None), *windows_at(x, corner, width))] = candidate.movedim(-1, 0)
            cost[n] += (energy_of(y, matrix) - before) / candidate.numel()
        assert int(found[k]) == int(source.numbers[cost.argmin()])
        by_likeness += int(unlike.argmin() == cost.argmin())
    assert by_likeness < 0.8 * len(grid)


def energy_of(x: Tensor, matrix: Tensor) -> float:
    """x^T F x of a video (C, T, H, W), in double precision."""
    flat = x.double().flatten(1)
    return float((flat @ matrix * flat).sum())


@every_way
@pytest.mark.parametrize("width", WINDOWS)
def test_without_a_video_a_candidate_is_charged_for_its_own_springs(
    loop: bool, wrap: bool, masked: bool, width: tuple[int, ...]
) -> None:
    made, corners = term(loop, wrap, masked), corners_of(width, loop, wrap)
    windows = torch.rand(len(corners), *width, 2, generator=generator(7))
    charged, numbers = made.charge(None)(corners, windows), torch.arange(math.prod(SHAPE)).view(SHAPE)
    for corner, window, cost in zip(corners, windows, charged, strict=True):
        pixels = numbers[windows_at(numbers, corner, width)].flatten().tolist()
        values = dict(zip(pixels, window.view(-1, 2).double(), strict=True))
        own = [row for row in springs(made) if row.keys() <= values.keys()]
        stretched = [sum((entry * values[pixel] for pixel, entry in row.items()), torch.zeros(2)) for row in own]
        expected = made.weight * sum(float(s.square().sum()) for s in stretched) / window.numel()
        assert float(cost) == pytest.approx(expected, abs=1e-5)


def test_the_engine_makes_a_video_that_follows_the_flow() -> None:
    noise = torch.rand(1, 10, 34, 34, generator=generator())
    clip = torch.nn.functional.avg_pool3d(noise[None], (3, 5, 5), 1)[0]
    clip = (clip - clip.amin()) / (clip.amax() - clip.amin())
    flows = flow.uniform(1.0)(0.0, (16, 20))[None].expand(5, -1, -1, -1)
    settings = Settings(levels=(Level(2, 8, 2), Level(1, 8, 2)))

    def made(weight: float) -> tuple[Tensor, list]:
        result = optimize(
            Exemplar.of(clip), (6, 16, 20), settings=settings, terms=VolumeFlow(flows, weight) if weight else ()
        )
        return result.image, result.energies

    free, (bound, rows) = made(0.0)[0], made(30.0)
    assert all(0 < row["residual"] <= 1e-4 for row in rows)
    assert VolumeFlow(flows).energy(bound) < 0.2 * VolumeFlow(flows).energy(free)
    assert float(bound.std()) > 0.3 * float(clip.std())


def test_flows_of_another_size_are_refused() -> None:
    flows = torch.zeros(3, 2, 6, 7)
    with pytest.raises(InputError, match=r"for a video of shape \(4, 6, 7\), but the output is \(5, 6, 7\)"):
        VolumeFlow(flows).at((1, 1, 1), (5, 6, 7))
    with pytest.raises(InputError, match=r"for a video of shape \(3, 6, 7\), but the output is \(4, 6, 7\)"):
        VolumeFlow(flows, loop=True).at((1, 1, 1), (4, 6, 7))
    with pytest.raises(InputError, match=r"for a video of shape \(4, 6, 7\), but the output is \(6, 7\)"):
        VolumeFlow(flows).at((1, 1), (6, 7))
    with pytest.raises(InputError, match=r"flows have shape \(2, 6, 7\)"):
        VolumeFlow(flows[0])
    with pytest.raises(InputError, match="a loop has 1 frames"):
        VolumeFlow(flows[:1], loop=True)
    with pytest.raises(InputError, match="42 vectors that are NaN"):
        VolumeFlow(flows + torch.tensor([0.0, 0.0, math.nan]).view(3, 1, 1, 1))
    with pytest.raises(InputError, match=r"the weight of the flow is -1"):
        VolumeFlow(flows, -1.0)


def test_coarser_flows_are_counted_in_the_pixels_of_either_axis() -> None:
    flows = torch.tensor([3.0, -8.0]).view(1, 2, 1, 1).expand(2, 2, 12, 9)
    made = coarser(flows, (4, 3), None)
    assert torch.equal(made, torch.tensor([1.0, -2.0]).view(1, 2, 1, 1).expand(2, 2, 3, 3))
