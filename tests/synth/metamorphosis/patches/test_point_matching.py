"""Robust point matching on motions that are known, and what holds for any sets."""

from collections.abc import Callable

import pytest
import torch
from torch import Tensor

from synth.metamorphosis.patches import point_matching
from synth.metamorphosis.patches.feature_points import Points
from synth.metamorphosis.patches.point_matching import Matching, match
from synth.metamorphosis.patches.thin_plate import Splines

WIDTH = 33
Motion = Callable[[Tensor], Tensor]


def affine(x: Tensor) -> Tensor:
    return (x - 16) @ torch.tensor([[0.08, 0.1], [-0.1, -0.05]]) + torch.tensor([1.5, -2.0])


def smooth(x: Tensor) -> Tensor:
    return 2.5 * torch.stack([torch.sin(x[..., 1] / 8), torch.cos(x[..., 0] / 10)], -1)


def clouds(motion: Motion, count: int = 40, inliers: int = 23, outliers: int = 0, noise: float = 0.0, seed: int = 0):
    """Sets of points, moved and shuffled, each with outliers of its own."""
    generator = torch.Generator().manual_seed(seed)

    def anywhere(number: int) -> Tensor:
        return 1 + 31 * torch.rand(count, number, 2, generator=generator)

    first = anywhere(inliers)
    second = first + motion(first) + noise * torch.randn(first.shape, generator=generator)
    sets = [torch.cat([part, anywhere(outliers)], 1) for part in (first, second)]
    sets[1] = sets[1][:, torch.randperm(inliers + outliers, generator=generator)]
    there = torch.ones(count, inliers + outliers, dtype=torch.bool)
    return tuple(Points(part, there) for part in sets)


def far(splines: Splines, motion: Motion, sign: int) -> float:
    """The root mean square error of motions in the inner part of a patch, the median of all pairs."""
    places = torch.cartesian_prod(torch.arange(5.0, 29.0, 3.0), torch.arange(5.0, 29.0, 3.0))
    if sign < 0:
        return far_back(splines, motion, places)
    return float((splines(places) - motion(places)).square().sum(2).mean(1).median().sqrt())


def far_back(splines: Splines, motion: Motion, places: Tensor) -> float:
    return float((splines(places + motion(places)) + motion(places)).square().sum(2).mean(1).median().sqrt())


@pytest.mark.parametrize("motion", [affine, smooth])
@pytest.mark.parametrize(("outliers", "noise", "most"), [(0, 0.0, 0.5), (10, 0.3, 1.2)])
def test_known_motions_are_found_among_outliers_and_noise(motion, outliers, noise, most):
    found = match(*clouds(motion, outliers=outliers, noise=noise), WIDTH)
    still = float(motion(torch.cartesian_prod(torch.arange(33.0), torch.arange(33.0))).square().sum(1).mean().sqrt())
    assert still > 2.4
    assert far(found.there, motion, 1) < most
    assert far(found.back, motion, -1) < most


def test_a_set_and_itself_are_one():
    points = clouds(affine, outliers=10)[0]
    found = match(points, points, WIDTH)
    places = torch.tensor([[0.0, 0.0], [16.0, 20.0], [32.0, 3.0]])
    for splines in (found.there, found.back):
        assert float(splines(places).abs().max()) < 1e-4
    same = found.correspondences.diagonal(dim1=1, dim2=2)
    assert float(same.mean()) > 0.7  # what is left are neighbors nearer than the mean
    torch.testing.assert_close(found.correspondences, found.correspondences.mT, atol=1e-4, rtol=0)
    assert float(found.there.penalty.max()) < 1e-6


def test_the_other_way_round_is_the_same():
    first, second = clouds(smooth, outliers=6, noise=0.3)
    second = Points(second.places[:, :20], second.there[:, :20])
    found, swapped = match(first, second, WIDTH), match(second, first, WIDTH)
    places = torch.rand(30, 2, generator=torch.Generator().manual_seed(1)) * 33
    torch.testing.assert_close(found.there(places), swapped.back(places), atol=2e-3, rtol=0)
    torch.testing.assert_close(found.correspondences, swapped.correspondences.mT, atol=1e-3, rtol=0)
    torch.testing.assert_close(found.error, swapped.error, atol=1e-2, rtol=1e-3)


def test_a_batch_is_its_members_and_padding_changes_nothing(monkeypatch):
    first, second = clouds(smooth, 8, outliers=6, noise=0.3)
    there = torch.arange(29) < torch.tensor([29, 0, 20, 1, 2, 29, 12, 29])[:, None]
    first = Points(torch.where(there[..., None], first.places, 99.0), there)
    places = torch.rand(30, 2, generator=torch.Generator().manual_seed(1)) * 33
    whole = match(first, second, WIDTH)
    monkeypatch.setattr(point_matching, "_CHUNK", 3 * 29 * 29)
    pieces = match(first, second, WIDTH)
    for k in range(8):
        one = Points(first.places[k : k + 1, there[k]], there[k : k + 1, there[k]])
        alone = match(one, Points(*(tensor[k : k + 1] for tensor in second)), WIDTH)
        for found in (pieces, whole):
            torch.testing.assert_close(found.there(places)[k], alone.there(places)[0], atol=5e-3, rtol=0)
            torch.testing.assert_close(found.back(places)[k], alone.back(places)[0], atol=5e-3, rtol=0)
            torch.testing.assert_close(found.correspondences[k, there[k]], alone.correspondences[0], atol=2e-3, rtol=0)
            torch.testing.assert_close(found.error[k], alone.error[0], atol=2e-2, rtol=2e-3)


def test_sets_without_points_stay_where_they_are():
    first, second = clouds(affine, 3)
    none = Points(second.places, torch.zeros_like(second.there))
    places = torch.tensor([[0.0, 0.0], [16.0, 9.0], [40.0, -3.0]])
    for pair in ((first, none), (none, second), (none, none)):
        found = match(*pair, WIDTH)
        for part in (found.there(places), found.back(places), found.correspondences, found.error):
            assert float(part.abs().max()) == 0
    nowhere = Points(torch.zeros(3, 0, 2), torch.zeros(3, 0, dtype=torch.bool))
    assert float(match(first, nowhere, WIDTH).there(places).abs().max()) == 0
    assert match(Points(*(t[:0] for t in first)), Points(*(t[:0] for t in second)), WIDTH).error.shape == (0,)


def test_a_point_without_a_partner_keeps_its_place():
    corner = torch.cartesian_prod(torch.arange(2.0, 17.0, 4.0), torch.arange(2.0, 17.0, 4.0))[None]
    moved = corner + torch.tensor([2.0, 0.0])
    lone = torch.tensor([[[30.0, 30.0], [27.0, 31.0], [31.0, 26.0]]])
    first = torch.cat([corner, lone], 1)
    with_lone, without = (
        match(Points(p, torch.ones(p.shape[:2], dtype=torch.bool)), Points(moved, torch.ones(1, 16, dtype=torch.bool)),
              WIDTH) for p in (first, corner)
    )  # fmt: skip
    assert float(with_lone.correspondences[0, 16:].sum()) < 0.05
    place = torch.tensor([[29.0, 29.0]])
    assert float(without.there(place)[0, 0, 0]) == pytest.approx(2, abs=0.3)
    assert abs(float(with_lone.there(place)[0, 0, 0])) < 0.6
    assert float(with_lone.there(torch.tensor([[8.0, 8.0]]))[0, 0, 0]) == pytest.approx(2, abs=0.3)


def test_few_points_in_one_corner_do_not_tear_the_patch():
    """Three pixels in a row, turned: what is known of one corner does not swing the others around."""
    row = torch.tensor([[[2.0, 2.0], [3.0, 2.0], [4.0, 2.0], [5.0, 2.0]]])
    column = torch.tensor([[[3.0, 1.0], [3.0, 2.0], [3.0, 3.0], [3.0, 4.0]]])
    found = match(*(Points(p, torch.ones(1, 4, dtype=torch.bool)) for p in (row, column)), WIDTH)
    corners = torch.tensor([[0.0, 0], [32, 0], [0, 32], [32, 32]])
    assert float(found.there(corners).norm(dim=2).max()) < 3


def test_the_error_is_equation_1():
    first, second = clouds(smooth, 3, outliers=6, noise=0.3)
    found = match(first, second, WIDTH)
    spacing = torch.stack([point_matching._spacing(side, WIDTH) for side in (first, second)]).mean(0)
    assert float(spacing.min()) > point_matching._DENSEST * WIDTH
    stiff = point_matching._STIFF * (point_matching._END * spacing) ** 2
    for k in range(3):
        there, back = (side(points.places)[k] for side, points in ((found.there, first), (found.back, second)))
        p, q, misfit = first.places[k], second.places[k], 0.0
        for i in range(29):
            for j in range(29):
                apart = (p[i] + there[i] - q[j]).square().sum() + (q[j] + back[j] - p[i]).square().sum()
                misfit += float(found.correspondences[k, i, j] * apart / 2)
        energy = misfit + float(stiff[k] * (found.there.penalty[k] + found.back.penalty[k]) / 2)
        assert float(found.error[k]) == pytest.approx(energy, rel=1e-3)


def test_patches_of_twice_the_size_are_matched_alike():
    first, second = clouds(smooth, 5, outliers=4)
    found = match(first, second, WIDTH)
    larger = match(*(Points(2 * side.places, side.there) for side in (first, second)), 2 * WIDTH)
    torch.testing.assert_close(larger.correspondences, found.correspondences, atol=2e-3, rtol=0)
    torch.testing.assert_close(larger.error, 4 * found.error, rtol=1e-2, atol=1e-2)


def test_rows_and_columns_sum_to_one_at_most():
    soft = match(*clouds(smooth, outliers=10), WIDTH).correspondences
    assert float(soft.min()) >= 0
    assert max(float(soft.sum(axis).max()) for axis in (1, 2)) < 1 + 1e-5


def test_threads_do_not_change_bits():
    sets, made = clouds(smooth, 500, outliers=9), list[Matching]()
    for count in (1, 2):
        torch.set_num_threads(count)
        made.append(match(*sets, WIDTH))
    assert torch.equal(made[0].correspondences, made[1].correspondences)
    assert torch.equal(made[0].there.weights, made[1].there.weights)
    assert torch.equal(made[0].error, made[1].error)
