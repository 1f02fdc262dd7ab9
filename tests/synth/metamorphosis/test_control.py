"""Optimal control on pairs of which the way is known; ends, reversal, folds, descent."""

import itertools

import pytest
import torch
from pictures import cloud, disc, spots

import synth
from flow.warps.integration import displaced, jacobian
from kwatra import InputError
from synth.metamorphosis.descent import descent, inner
from synth.metamorphosis.features import FOUND
from synth.metamorphosis.optimal_control import Control


def test_a_moved_disc_stays_one_disc():
    a, b, truth = (disc(64, x, 32, 9) for x in (26, 38, 32))
    made = synth.morph(a, b, 3, method="control")
    half = made.frames[1]
    assert float((half - truth).abs().mean()) < 0.2 * float(((a + b) / 2 - truth).abs().mean())
    assert float((half - truth).abs().max()) < 0.35
    # the way it moved: to the right, by half of it after half the time
    moved = displaced(made.film.velocity)[-1][:, 32, 26]
    assert float(moved[0]) == pytest.approx(11, abs=1.5)
    assert float(moved[1]) == pytest.approx(0, abs=0.5)


def test_a_shifted_and_recolored_texture_is_half_shifted_and_half_recolored_halfway():
    a, b, truth = (cloud(64, dx, part) for dx, part in ((3, 0), (-3, 1), (0, 0.5)))
    half = synth.morph(a, b, 3, method="control").frames[1]
    inside = (slice(None), slice(8, -8), slice(8, -8))
    error = float((half - truth)[inside].abs().mean() / truth[inside].std())
    faded = float(((a + b) / 2 - truth)[inside].abs().mean() / truth[inside].std())
    assert error < 0.05 < faded


def test_a_disc_splits_without_a_ghost():
    whole, parts = disc(64, 32, 32, 12), torch.maximum(disc(64, 20, 32, 8.5), disc(64, 44, 32, 8.5))
    half = synth.morph(whole, parts, 3, method="control").frames[1]
    between = ((half > 0.2) & (half < 0.7)).float().mean()
    ghost = (((whole + parts) / 2 > 0.2) & ((whole + parts) / 2 < 0.7)).float().mean()
    assert float(between) < 0.6 * float(ghost)
    assert 0.7 < float((half > 0.45).float().sum() / (whole > 0.45).float().sum()) < 1.3


@pytest.mark.parametrize("method", ["control", "registration", "blend"])
@pytest.mark.parametrize("tile", [False, True])
def test_the_ends_are_a_and_b(method, tile):
    a, b = spots(32, 0, 0.8), spots(32, 1, 0.3)
    film = synth.morph(a, b, [0, 0.4, 1], method=method, tile=tile, preset="fast")
    torch.testing.assert_close(film.frames[0], a, atol=1e-6, rtol=0)
    torch.testing.assert_close(film.frames[2], b, atol=1e-6, rtol=0)
    assert float((film.frames[1] - a).abs().mean()) > 0.01


@pytest.mark.parametrize("tile", [False, True])
def test_back_is_the_same_film_backwards(tile):
    a, b = spots(32, 0, 0.8), spots(32, 1, 0.3)
    options = {"method": "control", "iterations": 8, "tile": tile}
    there, back = synth.morph(a, b, 5, **options), synth.morph(b, a, 5, **options)
    for first, second in zip(there.frames, reversed(back.frames), strict=True):
        torch.testing.assert_close(first, second, atol=2e-6, rtol=0)
    assert torch.equal(there.film.velocity, -back.film.velocity.flip(0))
    assert float(there.film.velocity.abs().max()) > 0.05


def test_the_energy_never_rises_and_no_map_folds():
    film = synth.morph(spots(40, 0, 0.8), spots(40, 1, 0.3), 3, method="control", alpha=3.0, gamma=0.1).film
    for level in {row["level"] for row in film.energies}:
        totals = [row["total"] for row in film.energies if row["level"] == level]
        assert totals == sorted(totals, reverse=True)
        assert len(totals) > 3
    for velocity in (film.velocity, -film.velocity.flip(0)):
        assert float(jacobian(displaced(velocity)).min()) > 0
    row = film.energies[-1]
    assert row["total"] == pytest.approx(row["velocity"] + row["change"])
    reasons = ("settled", "iterations of the last level", "no step lowers the energy")
    assert any(reason in film.remarks[0] for reason in reasons)
    assert any("no map folds" in remark for remark in film.remarks)


def test_dear_motion_is_a_dissolve():
    """Figure 13: the larger alpha and gamma, the more the metamorphosis is a blend."""
    a, b = disc(48, 20, 24, 8), disc(48, 28, 24, 8)
    half = synth.morph(a, b, 3, method="control", alpha=1e5, gamma=1e3).frames[1]
    torch.testing.assert_close(half, (a + b) / 2, atol=1e-3, rtol=0)


def test_features_decide_what_moves_where():
    """Two discs could move to either place; marked ones move onto each other (eq. 14)."""
    plain = torch.full((1, 48, 48), 0.5)
    marks = disc(48, 18, 24, 6)[0], disc(48, 28, 24, 6)[0]
    a, b = plain + 0.02 * disc(48, 18, 18, 3), plain + 0.02 * disc(48, 18, 18, 3)
    options = {"method": "control", "sigma": 0.3, "iterations": 12}
    marked = synth.morph(a, b, 3, features=marks, **options).film.velocity.sum(0)[:, 24, 18]
    unmarked = synth.morph(a, b, 3, **options).film.velocity.sum(0)
    assert float(marked[0]) > 5
    assert float(unmarked.abs().max()) < 0.1


@pytest.mark.parametrize("find", ["edges", "blobs"])
def test_features_are_found(find):
    image = disc(48, 24, 24, 10)
    found = FOUND[find](image)
    assert found.shape == (1, 48, 48)
    across = found[0, 24]
    assert float(across[14]) > 5 * float(across[2])
    film = synth.morph(image, disc(48, 28, 24, 10), 3, method="control", find=find, preset="fast").film
    assert "features" in film.energies[-1]


def test_one_color_is_a_texture_too():
    gray, light = torch.full((1, 20, 20), 0.3), torch.full((1, 20, 20), 0.9)
    frames = synth.morph(gray, light, 3, method="control").frames
    for frame, value in zip(frames, (0.3, 0.6, 0.9), strict=True):
        torch.testing.assert_close(frame, torch.full((1, 20, 20), value), atol=1e-6, rtol=0)


def test_any_number_of_threads_gives_the_same_bits():
    a, b = spots(32, 0, 0.8), spots(32, 1, 0.3)
    films = []
    for count in (1, 3):
        torch.set_num_threads(count)
        films.append(synth.morph(a, b, [0.3, 0.5], method="control", iterations=5, retexture=True, preset="fast"))
    assert torch.equal(films[0].film.velocity, films[1].film.velocity)
    assert torch.equal(films[0].frames[1], films[1].frames[1])


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"sigma": 0}, "sigma is 0"),
        ({"find": "faces"}, "find is 'faces'; allowed are none, edges, blobs"),
    ],
)
def test_settings_that_are_none_are_refused(options, sentence):
    with pytest.raises(InputError, match=sentence):
        Control(**options)


@pytest.mark.parametrize("method", ["control", "registration"])
@pytest.mark.parametrize(
    ("options", "sentence"),
    [({"alpha": -1}, "alpha is -1"), ({"steps": 0}, "steps is 0"), ({"tolerance": 1.0}, "a share")],
)
def test_how_to_search_is_told_through_the_door(method, options, sentence):
    with pytest.raises(InputError, match=sentence):
        synth.morph(spots(32, 0, 0.8), spots(32, 1, 0.3), 3, method=method, **options)
    with pytest.raises(InputError, match="no option 'beta'; it takes alpha, gamma, steps, iterations, tolerance"):
        synth.morph(spots(32, 0, 0.8), spots(32, 1, 0.3), 3, method=method, beta=1)


def test_the_descent_finds_the_bottom_of_a_bowl():
    scale = torch.logspace(0, 2, 12).view(2, 2, 3, 1)
    goal = torch.arange(12.0).view(2, 2, 3, 1)

    def bowl(at):
        apart = at - goal
        return float(inner(apart, scale * apart)), 2 * scale * apart

    points = []
    for point in descent(bowl, torch.zeros_like(goal), lambda change: float(change.abs().max())):
        points.append(point)
        if len(points) > 60:
            break
    energies = [point.energy for point in points]
    assert energies == sorted(energies, reverse=True)
    assert len(set(energies)) == len(energies)
    torch.testing.assert_close(points[-1].at, goal, atol=1e-2, rtol=1e-3)


def test_no_step_of_the_descent_moves_a_pixel_far():
    def slope(at):
        return -1e6 * float(at.sum()), torch.full_like(at, -1e6)

    points = []
    for point in descent(slope, torch.zeros(1, 2, 2, 2), lambda change: float(change.abs().max())):
        points.append(point.at)
        if len(points) == 4:
            break
    steps = [float((after - before).abs().max()) for before, after in itertools.pairwise(points)]
    assert steps[0] == pytest.approx(0.25)
    assert max(steps) <= 2.0001
