"""Metamorphosis by patterns, where it is known what must happen."""

from unittest.mock import Mock

import numpy as np
import pytest
import torch
from skimage import measure
from torch import Tensor

from flow.warps import end_point_error
from kwatra import InputError
from synth.metamorphosis.bands import dissolved
from synth.metamorphosis.method import Film, Pair
from synth.metamorphosis.patterns import PatternMorph, Patterns, method
from synth.metamorphosis.patterns.film import median, within

SIDE, PITCH, RADIUS = 96, 24, 7.0


def lattice(shift: tuple[float, float] = (0, 0)) -> np.ndarray:
    x, y = np.meshgrid(np.arange(PITCH / 2, SIDE, PITCH), np.arange(PITCH / 2, SIDE, PITCH))
    return np.stack([x, y], -1).reshape(-1, 2) + shift


def texture(centers: np.ndarray, square: bool = False) -> Tensor:
    """Bright discs, or squares, on dark ground, (3, 96, 96), with a little noise."""
    x, y = np.meshgrid(np.arange(SIDE), np.arange(SIDE))
    image = np.full((SIDE, SIDE), 0.2)
    for cx, cy in centers:
        away = np.maximum(abs(x - cx), abs(y - cy)) if square else np.hypot(x - cx, y - cy)
        image += 0.6 * np.clip(RADIUS - away + 0.5, 0, 1)
    image = np.clip(image + np.random.default_rng(0).normal(0, 0.01, image.shape), 0, 1)
    return torch.from_numpy(image).float().expand(3, -1, -1).contiguous()


def film(a: Tensor, b: Tensor, count: int = 5, **settings: object) -> Film:
    times = [k / (count - 1) for k in range(count)]
    return PatternMorph(**settings)(Pair(a, b), times, 0, lambda what, part: None)  # type: ignore[arg-type]


def parts(frame: Tensor) -> list[object]:
    return [part for part in measure.regionprops(measure.label(frame[0].numpy() > 0.5)) if part.area > 20]


def test_discs_become_squares_stay_where_they_are_and_the_ends_are_a_and_b() -> None:
    a, b = texture(lattice()), texture(lattice(), square=True)
    made = film(a, b)
    assert torch.allclose(made.frames[0], a, atol=1e-5)
    assert torch.allclose(made.frames[-1], b, atol=1e-5)
    for frame in made.frames:
        middles = np.array([part.centroid[::-1] for part in parts(frame)])
        assert len(middles) == 16
        assert np.linalg.norm(middles[:, None] - lattice()[None], axis=2).min(0).max() < 0.5
    areas = [np.mean([part.area for part in parts(frame)]) for frame in made.frames]
    assert np.all(np.diff(areas) > 0)
    assert areas[2] == pytest.approx((areas[0] + areas[4]) / 2, rel=0.1)


def test_the_film_of_a_shifted_lattice_is_the_shift_told_when_it_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    told = Mock(wraps=method._velocity)
    monkeypatch.setattr(method, "_velocity", told)
    a, b = texture(lattice()), texture(lattice((6, 4)))
    made = film(a, b)
    assert torch.allclose(made.frames[0], a, atol=1e-5)
    assert torch.allclose(made.frames[-1], b, atol=1e-5)
    half = texture(lattice((3, 2)))
    inside = slice(16, 80)
    assert float((made.frames[2] - half)[:, inside, inside].abs().mean()) < 0.02
    told.assert_not_called()
    assert made.velocity is not None
    assert made.velocity is made.velocity
    told.assert_called_once()
    shift = torch.tensor([1.5, 1.0])[:, None, None].expand_as(made.velocity[0])
    assert end_point_error(made.velocity[0], shift) < 0.3


def test_what_is_more_in_b_grows_from_nothing() -> None:
    made = film(texture(np.delete(lattice(), 5, 0)), texture(lattice()))
    x, y = lattice()[5].astype(int)
    own = [float((frame[0, y - 9 : y + 10, x - 9 : x + 10] > 0.5).sum()) for frame in made.frames]
    assert own[0] == 0
    assert own[-1] > 100
    assert np.all(np.diff(own) >= 0)
    assert any("1 grow from nothing" in remark for remark in made.remarks)


def test_two_orders_of_landmarks_make_two_films() -> None:
    corners = RADIUS * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1.0]])
    straight = Patterns((SIDE, SIDE), lattice()[5] + corners, lattice()[:, None] + corners)
    turned = Patterns((SIDE, SIDE), np.roll(straight.landmarks, 1, 0), np.roll(straight.found, 1, 1))
    a = texture(lattice(), square=True)
    films = [film(a, a, patterns_a=straight, patterns_b=other) for other in (straight, turned)]
    assert torch.allclose(films[0].frames[2], a, atol=0.02)
    assert float((films[1].frames[2] - a).abs().mean()) > 0.03  # halfway through a quarter turn they are smaller


def test_landmarks_of_one_pattern_are_enough() -> None:
    angles = np.arange(8) / 4 * np.pi
    ring = RADIUS * np.stack([np.cos(angles), np.sin(angles)], 1)
    one = Patterns((SIDE, SIDE), lattice()[5] + ring)
    made = film(texture(lattice()), texture(lattice((6, 4))), patterns_a=one)
    assert "A: 16 patterns" in made.remarks
    half = texture(lattice((3, 2)))
    assert float((made.frames[2] - half)[:, 20:76, 20:76].abs().mean()) < 0.03


def test_a_texture_becomes_itself_without_a_change() -> None:
    a = texture(lattice())
    for frame in film(a, a).frames:
        assert torch.allclose(frame, a, atol=1e-4)


def test_transitions_keep_to_their_times() -> None:
    a, b = texture(lattice()), texture(lattice((6, 4)))
    late = film(a, b, warping=(0.5, 1.0), dissolving=(0.75, 1.0))
    assert torch.allclose(late.frames[2], a, atol=1e-5)
    assert not torch.allclose(late.frames[3], a, atol=1e-2)
    assert within(0.5, (0.25, 0.75)) == 0.5


def test_sizes_may_differ_and_frames_have_what_is_common() -> None:
    a, b = texture(lattice())[:, :80], texture(lattice((3, 1)))[:, :, :90]
    made = film(a, b, 3)
    assert {tuple(frame.shape) for frame in made.frames} == {(3, 80, 90)}
    assert "12 patterns are paired" in made.remarks  # the fourth row of B lies where A ends


def test_a_dissolve_of_unlike_details_keeps_their_contrast() -> None:
    a, b = torch.rand(2, 3, 64, 64, generator=torch.Generator().manual_seed(0)) * 0.3 + 0.35
    assert float(dissolved(a, b, 0.5, Pair(a, b)).std()) == pytest.approx(float(a.std()), rel=0.1)
    assert torch.equal(dissolved(a, b, 0.0, Pair(a, b)), a)
    assert torch.equal(dissolved(a, b, 1.0, Pair(a, b)), b)
    assert torch.allclose(dissolved(a, a, 0.5, Pair(a, a)), a, atol=1e-5)


def test_a_dissolve_of_opposite_tones_does_not_make_detail_of_noise() -> None:
    tones, noise = torch.randn(2, 1, 48, 48, generator=torch.Generator().manual_seed(2))
    a, b = 0.5 + 0.1 * tones, 0.5 - 0.1 * tones + 0.04 * noise
    left = float(torch.lerp(a, b, 0.5).std())
    assert 0.9 * left < float(dissolved(a, b, 0.5, Pair(a, b)).std()) < 1.3 * left


def test_the_median_in_time_takes_out_what_only_one_frame_has() -> None:
    frames = [torch.full((1, 4, 4), k / 10) for k in range(5)]
    frames[2][0, 1, 1] = 1
    smoothed = median(frames, 3)
    assert float(smoothed[2][0, 1, 1]) == pytest.approx(0.3)
    assert torch.equal(smoothed[0], frames[0])
    assert all(torch.equal(x, y) for x, y in zip(median(frames, 1), frames, strict=True))


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"median": 2}, "odd number"),
        ({"scale_elements": 0.0}, "above 0 and up to 1"),
        ({"warping": (0.6, 0.4)}, "two times in order"),
        ({"dissolving": (0.0, 1.5)}, "two times in order"),
    ],
)
def test_bad_settings_are_refused(settings: dict[str, object], match: str) -> None:
    with pytest.raises(InputError, match=match):
        PatternMorph(**settings)  # type: ignore[arg-type]


def test_unequal_counts_of_landmarks_are_refused() -> None:
    square = Patterns((SIDE, SIDE), np.array([[5, 5], [15, 5], [15, 15], [5, 15.0]]))
    triangle = Patterns((SIDE, SIDE), square.landmarks[:3])
    with pytest.raises(InputError, match="4 landmarks in A and 3 in B; give equally many"):
        PatternMorph(square, triangle)


def test_textures_without_elements_are_refused() -> None:
    three = texture(lattice()[:3])
    with pytest.raises(InputError, match="found 3 patterns in B; patterns needs at least 4"):
        film(texture(lattice()), three)
    noise = torch.rand(3, SIDE, SIDE, generator=torch.Generator().manual_seed(0))
    with pytest.raises(InputError, match=r"found (no distinct elements|\d+ patterns) in A"):
        film(noise, texture(lattice()))


def test_patterns_of_another_image_are_refused() -> None:
    other = Patterns((50, 60), np.array([[5, 5], [15, 5], [15, 15.0]]))
    with pytest.raises(InputError, match="of an image of 60x50 but A is 96x96"):
        film(texture(lattice()), texture(lattice()), patterns_a=other)


def test_that_elements_are_crowded_is_told_where_nobody_said_how_they_are_scaled(monkeypatch) -> None:
    monkeypatch.setattr(method, "crowding", lambda ways: 0.5)
    a = texture(lattice())
    assert film(a, a).remarks[-1] == "elements are crowded: they are scaled by 0.50 while they move"
    assert not any("crowded" in remark for remark in film(a, a, scale_elements=0.5).remarks)
    monkeypatch.setattr(method, "crowding", lambda ways: 1.0)
    assert not any("crowded" in remark for remark in film(a, a).remarks)
