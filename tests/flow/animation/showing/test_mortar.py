"""Mortar along the seams that tear a wall."""

import numpy as np
import pytest
import torch
from bench_elements import cut_elements, places_of
from made import MADE
from torch import Tensor

import flow
from flow.animation.film.film import Film
from flow.animation.showing.mortar import _KEPT, Mortar
from flow.warps import lookup, pixel_coordinates
from kwatra import Exemplar

HIGH, LONG, JOINT, SIDE = 16, 40, 2, 120


def wall() -> tuple[Exemplar, np.ndarray]:
    """Courses half a brick apart, lit from above, and where their joints are (120, 120)."""
    row, below = np.divmod(np.arange(SIDE), HIGH)
    beside = (np.arange(SIDE) + (row % 2 * LONG // 2)[:, None]) % LONG
    joints = (below[:, None] < JOINT) | (beside < JOINT)
    image = np.where(joints, 0.8, 0.2 + 0.01 * below[:, None])
    return Exemplar.of(torch.from_numpy(image)[None].float()), joints


def pointed(source: Tensor, inside: Tensor | None = None) -> Tensor:
    exemplar, joints = wall()
    there = torch.ones_like(source[0], dtype=torch.bool) if inside is None else inside
    return mended(Mortar(exemplar, joints, (HIGH * LONG) ** 0.5), source, there)


def mended(mortar: Mortar, source: Tensor, inside: Tensor) -> Tensor:
    return mortar.shown(source, inside, mortar.torn(source, inside))


def two_copies(down: float, right: float, column: int = 30) -> Tensor:
    """A frame (60, 60) of the wall, which from a column on shows what is so many px away."""
    source = pixel_coordinates((60, 60)) + 8.0
    source[:, :, column:] += torch.tensor([right, down]).view(2, 1, 1)
    return source


def shows(source: Tensor) -> np.ndarray:
    """Where (H, W) source coordinates show joints."""
    x, y = source.round().long().numpy()
    return wall()[1][y, x]


def test_a_seam_through_bricks_becomes_a_joint_as_wide_as_others() -> None:
    source = two_copies(down=7, right=13)
    before, after = shows(source), shows(pointed(source))
    rows = ~before[:, 27:33].any(1)
    rows[:JOINT] = rows[-JOINT:] = False  # what is torn there is short
    assert rows.sum() > 30
    assert after[rows, 29:31].all()
    assert not after[rows, 27].any()
    assert not after[rows, 32].any()
    assert after[before].all()


def test_what_is_far_from_such_a_seam_stays_bit_for_bit() -> None:
    source = two_copies(down=7, right=13)
    changed = (pointed(source) != source).any(0).numpy()
    assert changed.any()
    assert not changed[:, :25].any()
    assert not changed[:, 35:].any()
    assert not changed[shows(source)].any()


@pytest.mark.parametrize("right", [0, LONG, LONG + 1])
def test_what_goes_on_in_step_stays_as_it_is(right: int) -> None:
    """One copy; one that goes on a period further, so that no seam is seen; one that makes bricks a pixel shorter."""
    source = two_copies(down=0, right=right)
    assert torch.equal(pointed(source), source)


def test_copies_of_one_brick_that_hardly_differ_are_one() -> None:
    source = two_copies(down=3, right=0)
    bricks = slice(12, 22)  # a course that shows the same bricks on both sides
    assert torch.equal(pointed(source)[:, bricks], source[:, bricks])


def test_what_is_torn_is_a_mean_over_frames() -> None:
    """Of the same seams it stays as it is; what is carried along moves; and what has just come counts by its share."""
    exemplar, joints = wall()
    mortar, inside = Mortar(exemplar, joints, 25.0), torch.ones(60, 60, dtype=torch.bool)
    still, right = (lookup(torch.tensor([by, 0.0]).view(2, 1, 1).expand(2, 60, 60)) for by in (0.0, 4.0))
    torn = mortar.torn(two_copies(7, 13), inside)
    assert torch.allclose(mortar.torn(two_copies(7, 13), inside, still, torn), torn, atol=1e-5)
    moved = mortar.torn(two_copies(7, 13).roll(4, 2), inside, right, torn)
    assert torch.allclose(moved[:, 14:50], torn[:, 10:46], atol=1e-5)
    whole = mortar.torn(two_copies(0, 0), inside)
    assert float(whole.min()) == float(whole.max()) > float(torn.min())
    came = mortar.torn(two_copies(7, 13), inside, still, whole)
    assert torch.allclose(came, torn + _KEPT * (whole - torn), atol=1e-5)


def test_a_frame_ends_at_nothing_that_is_torn() -> None:
    source, inside = two_copies(down=7, right=13), torch.ones(60, 60, dtype=torch.bool)
    inside[:, 30:] = False
    assert torch.equal(pointed(source, inside), source)


def test_mortar_is_read_from_the_exemplar_and_from_nowhere_else() -> None:
    exemplar, joints = wall()
    exemplar.owner[:, 60:] = -1
    source = two_copies(down=7, right=13) * 0.5
    shown = mended(Mortar(exemplar, joints, 25.0), source, torch.ones(60, 60, dtype=torch.bool))
    x, y = shown.round().long()
    assert bool((exemplar.owner[y, x] >= 0).all())
    assert not torch.equal(shown, source)


def test_only_walls_of_long_elements_have_mortar() -> None:
    made = {kind: Film.of(Exemplar.of(MADE[kind](128, 24, 0).image)) for kind in ("bricks", "stones", "coins")}
    assert {kind for kind, film in made.items() if Mortar.of(film) is not None} == {"bricks"}
    moving = Film.of(Exemplar.of(MADE["bricks"](64, 24, 0).image[:, None].repeat(1, 9, 1, 1)))
    assert Mortar.of(moving) is None


def test_joints_looked_for_at_half_the_size_are_found_again() -> None:
    exemplar = Exemplar.of(MADE["bricks"](128, 32, 0).image)
    small = Film.of(exemplar)
    assert small.hidden is not None
    mortar = Mortar.of(small)
    large = Exemplar.of(exemplar.canvas.repeat_interleave(2, 1).repeat_interleave(2, 2))
    film = Film.of(large)
    film.__dict__["hidden"] = small.hidden.finer(2, large.shape)
    fine = Mortar.of(film)
    assert mortar is not None
    assert fine is not None
    same = fine._joints == mortar._joints.repeat(2, 0).repeat(2, 1)
    assert same.mean() > 0.95
    assert fine._joints.sum() > 0.8 * 4 * mortar._joints.sum()


def test_bricks_that_flow_are_parted_not_grown_together(monkeypatch: pytest.MonkeyPatch) -> None:
    made = MADE["bricks"](128, 24, 0)

    def mixed() -> float:
        """The share of bricks that are, over a few frames."""
        frames = list(flow.animate(made.image, flow.rotation(2.0), (160, 160), frames=31, seed=0))
        again = list(flow.animate(made.image, flow.rotation(2.0), (160, 160), frames=31, after=frames[28].state))
        assert torch.equal(again[-1].image, frames[-1].image)
        assert torch.equal(again[-1].where, frames[-1].where)
        places = [places_of(made.image)[*frame.where.numpy()] for frame in frames[20::5]]
        return float(np.mean([cut_elements(made.numbers.numpy(), shown)["mixed"] for shown in places]))

    parted = mixed()
    monkeypatch.setattr(Mortar, "of", lambda _: None)
    assert parted < 0.7 * mixed()
