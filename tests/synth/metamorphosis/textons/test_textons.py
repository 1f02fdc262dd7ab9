"""Texton masks: made, checked, moved; and the films made under them."""

from itertools import pairwise
from unittest.mock import Mock

import numpy as np
import pytest
import torch
from skimage import measure
from torch import Tensor

from flow.warps import pixel_coordinates
from kwatra import InputError
from synth.metamorphosis.method import Film, Pair
from synth.metamorphosis.textons import MovingMasks, TextonMorph, checked, colored, found
from synth.metamorphosis.textons.guided import guided

SIZE = (48, 56)
RED, WHITE, BLUE = (0.8, 0.1, 0.1), (0.9, 0.9, 0.9), (0.1, 0.2, 0.7)


def discs(shift: float = 0.0, radius: float = 5.0, missing: int | None = None) -> np.ndarray:
    """Whether pixels (48, 56) lie in discs on a lattice of 16 px."""
    x, y = np.meshgrid(np.arange(SIZE[1]), np.arange(SIZE[0]))
    centers = [(8 + 16 * j + shift, 8 + 16 * i) for i in range(3) for j in range(3)]
    kept = [center for number, center in enumerate(centers) if number != missing]
    return np.any([np.hypot(x - cx, y - cy) <= radius for cx, cy in kept], axis=0)


def painted(mask: np.ndarray, inside: tuple[float, ...], outside: tuple[float, ...]) -> Tensor:
    colors = np.where(mask[None], np.reshape(inside, (3, 1, 1)), np.reshape(outside, (3, 1, 1)))
    noise = np.random.default_rng(0).normal(0, 0.02, colors.shape)
    return torch.from_numpy(np.clip(colors + noise, 0, 1)).float()


A, B = painted(discs(), RED, WHITE), painted(discs(4), BLUE, WHITE)


def film(pair: Pair, count: int = 3, **settings: object) -> Film:
    return TextonMorph(**settings)(pair, np.linspace(0, 1, count).tolist(), 0, lambda *_: None)  # type: ignore[arg-type]


def test_masks_follow_colors_and_tolerance() -> None:
    assert np.array_equal(colored(A, RED, WHITE), discs())
    assert np.array_equal(colored(A, WHITE, RED), ~discs())
    assert np.array_equal(colored(A, RED, (0.9,)), discs())
    assert colored(A, RED, WHITE, tolerance=2.0).all()


def test_masks_are_found_without_colors() -> None:
    assert (found(A) != discs()).mean() < 0.03


def test_specks_are_cleaned_from_masks() -> None:
    speckled = discs()
    speckled[0, 0] = True
    assert np.array_equal(checked(speckled, A, "A"), discs())


def test_masks_of_a_texture_to_itself_stay() -> None:
    moving = MovingMasks.of(discs(), discs())
    for t in (0.0, 0.3, 1.0):
        assert np.array_equal(moving.at(t), discs())
    assert torch.allclose(moving.back(1.0, 0.3), pixel_coordinates(SIZE), atol=1e-4)


def test_elements_of_masks_move_and_are_not_blended() -> None:
    moving = MovingMasks.of(discs(), discs(4))
    assert (moving.at(0.5) != discs(2)).mean() < 0.02
    ways = moving.back(1.0, 0.0) - pixel_coordinates(SIZE)
    assert torch.allclose(ways, torch.tensor([-4.0, 0.0]).view(2, 1, 1).expand_as(ways), atol=0.1)


def boxes(*sides: tuple[int, int, int, int]) -> np.ndarray:
    """Whether pixels (48, 56) lie in boxes of top, bottom, left and right."""
    inside = np.zeros(SIZE, bool)
    for top, bottom, left, right in sides:
        inside[top:bottom, left:right] = True
    return inside


def test_elements_are_stretched_from_one_shape_to_the_other() -> None:
    """A box becomes one twice as wide, a box all the way, and carries what is in it along."""
    moving = MovingMasks.of(boxes((16, 32, 8, 24)), boxes((16, 32, 20, 52)))
    assert (moving.at(0.5) != boxes((16, 32, 14, 38))).mean() < 0.01
    assert torch.allclose(moving.back(1.0, 0.0)[:, 20, 24], torch.tensor([9.75, 20.0]), atol=0.1)


def test_elements_on_their_way_cover_what_is_between_and_do_not_merge() -> None:
    """Two flat boxes above each other become two high ones side by side: straight on they would overlap."""
    flat, high = boxes((14, 22, 10, 46), (26, 34, 10, 46)), boxes((6, 42, 16, 24), (6, 42, 30, 44))
    moving = MovingMasks.of(flat, high)
    assert np.array_equal(moving.at(0.0), flat)
    assert np.array_equal(moving.at(1.0), high)
    for t in (0.25, 0.5, 0.75):
        inside = moving.at(t)
        assert measure.label(inside, connectivity=1).max() == 2
        assert inside.sum() == pytest.approx((1 - t) * flat.sum() + t * high.sum(), abs=16)


def test_an_element_without_partner_grows() -> None:
    moving = MovingMasks.of(discs(missing=4), discs())
    areas = [int(moving.at(t)[18:30, 18:30].sum()) for t in (0.0, 0.25, 0.5, 0.75, 1.0)]
    assert areas[0] == 0
    assert all(later > earlier for earlier, later in pairwise(areas[1:]))
    assert measure.label(moving.at(0.5)).max() == 9


def test_frames_have_their_elements_where_the_mask_has_them() -> None:
    made = film(Pair(A, B))
    assert torch.equal(made.frames[0], A)
    assert torch.equal(made.frames[2], B)
    middle = made.frames[1].mean(0).numpy() < 0.6
    assert (middle != discs(2)).mean() < 0.08
    # purple: red of A over blue of B
    inside = made.frames[1][:, torch.from_numpy(discs(2, 3.0))].mean(1)
    assert torch.allclose(inside, torch.tensor([0.45, 0.15, 0.4]), atol=0.08)


def test_the_same_seed_gives_the_same_bits() -> None:
    assert torch.equal(film(Pair(A, B)).frames[1], film(Pair(A, B)).frames[1])


@pytest.mark.parametrize("size", [None, (40, 30), (50, 70)])
def test_published_frames_have_any_size(size: tuple[int, int] | None) -> None:
    pair = Pair(A[:, :32, :32].contiguous(), B[:, :32, :40].contiguous())
    masks = {"mask_a": discs()[:32, :32], "mask_b": discs(4)[:32, :40]}
    made = film(pair, 2, published=True, window_a=5, window_b=7, size=size, **masks)
    assert {tuple(frame.shape[1:]) for frame in made.frames} == {size or (32, 32)}
    # the first has the colors of A only, the last those of B
    for frame, color in zip(made.frames, (RED, BLUE), strict=True):
        away = [(frame - torch.tensor(each).view(3, 1, 1)).norm(dim=0) for each in (color, WHITE)]
        assert float(torch.minimum(*away).max()) < 0.2
        assert 0.15 < float((away[0] < away[1]).float().mean()) < 0.5


def test_the_published_search_is_exhaustive() -> None:
    from synth.metamorphosis.textons.raster import _nearest, _source, _window

    random = np.random.default_rng(1)
    image, mask = random.random((14, 17, 3), np.float32), (random.random((14, 17)) < 0.5).astype(np.float32)
    frame = random.random((9, 11, 3), np.float32)
    source, none = _source(image, mask, 5), np.zeros((9, 11, 2), np.int64)
    away = np.zeros(mask.shape)
    for dy, dx in np.ndindex(5, 5):
        there = np.roll(image, (2 - dy, 2 - dx), (0, 1))
        weight = np.exp(-((dy - 2) ** 2 + (dx - 2) ** 2) / (2 * 1.25**2)) * ((dy, dx) != (2, 2))
        away += weight * np.square(there - frame[(2 + dy) % 9, (4 + dx) % 11]).sum(2)
    for wanted in np.float32((0, 1)):  # of the type that the loop is compiled for
        best = _nearest(_window(frame, 4, 6, source), source, wanted, none, 4, 6)
        allowed = np.where(mask == wanted, away, np.inf)
        assert tuple(best) == np.unravel_index(allowed.argmin(), mask.shape)


def test_a_texture_of_one_color_has_no_mask() -> None:
    with pytest.raises(InputError, match="mask of A is no foreground"):
        film(Pair(torch.full((3, *SIZE), 0.5), B))


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"window_a": 4}, "window_a is 4; give an odd width"),
        ({"window_b": 1}, "window_b is 1"),
        ({"tolerance": -1.0}, "tolerance is -1"),
        ({"size": (10, 10)}, "for published frames only"),
        ({"colors_a": (RED, RED)}, "give two colors"),
        ({"colors_a": (RED, (0.5, float("nan"), 0.5))}, "no color of 3 finite values"),
        ({"colors_b": (RED, (0.5, 0.5))}, "no color of 3 finite values"),
        ({"mask_a": np.zeros(SIZE, bool)}, "mask of A is no foreground"),
        ({"mask_b": np.ones(SIZE, bool)}, "mask of B is all foreground"),
        ({"mask_b": np.ones((9, 9), bool)}, "mask of B is 9x9"),
        ({"published": True, "window_a": 49}, "49 wide but A 56x48"),
    ],
)
def test_what_cannot_be_used_is_refused(settings: dict[str, object], match: str) -> None:
    with pytest.raises(InputError, match=match):
        film(Pair(A, B), **settings)


def test_under_a_mask_that_stays_a_frame_shows_the_image(monkeypatch: pytest.MonkeyPatch) -> None:
    elsewhere = Mock(where=torch.zeros(2, *SIZE, dtype=torch.long))  # of which nothing is wanted
    monkeypatch.setattr("synth.metamorphosis.textons.guided.optimize", lambda *_, **__: elsewhere)
    places = pixel_coordinates(SIZE)
    still = Mock(at=lambda now: discs(), back=lambda now, before: places)
    for frame in guided(A, discs(), still, [0.0, 0.5, 1.0], 0):
        assert torch.equal(frame, A)
