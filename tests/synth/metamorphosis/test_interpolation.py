"""Textures in between, whole: ends, sameness, films that stay, maps that are kept, and what is refused."""

import weakref
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
import torch
from pictures import spots
from torch.nn.functional import avg_pool2d

import synth
from kwatra import Exemplar, InputError, element_size
from kwatra.scoring.quality import sliced_wasserstein
from synth.metamorphosis.judging import judge
from synth.metamorphosis.patches import passage
from synth.metamorphosis.patches.detail import strength
from synth.metamorphosis.patches.interpolation import PUBLISHED, Frame, Interpolation
from synth.metamorphosis.patches.method import PatchMorph
from synth.metamorphosis.patches.model import Making
from synth.metamorphosis.patches.weighting import Weighting

SIZE = 48
QUICK: dict[str, Any] = {"preset": "fast", "anchors": 100}


@pytest.fixture(scope="module")
def pair() -> tuple[torch.Tensor, torch.Tensor]:
    return spots(SIZE, 0, 0.9), spots(SIZE, 1, 0.1)


def sliced(image: torch.Tensor, texture: torch.Tensor) -> float:
    return sum(sliced_wasserstein(image, texture, scale=scale) for scale in (1, 2)) / 2


def colors(image: torch.Tensor) -> torch.Tensor:
    return image.flatten(1).mean(1)


def test_a_film_begins_in_a_and_ends_in_b(pair: tuple[torch.Tensor, torch.Tensor]) -> None:
    a, b = pair
    made = synth.morph(a, b, 5, method="patches", **QUICK)
    assert torch.allclose(made.frames[0], a, atol=1e-6)
    assert torch.allclose(made.frames[-1], b, atol=1e-6)
    figures = judge(made.frames, made.times, a, b)
    assert figures["near"] < 1.35
    assert figures["ghost"] < 0.2
    assert 0.85 < figures["sharpness"] < 1.2
    assert figures["steps"] < 1.8
    assert any("features" in remark for remark in made.remarks)


def test_where_a_and_b_cancel_each_other_the_film_ends_as_a_texture_of_b(
    pair: tuple[torch.Tensor, torch.Tensor], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(passage, "FAINT", 9.0)
    made = synth.morph(*pair, 3, method="patches", **QUICK)
    assert torch.allclose(made.frames[0], pair[0], atol=1e-6)
    assert float((colors(made.frames[-1]) - colors(pair[1])).abs().max()) < 0.03
    assert "cancel each other" in made.remarks[-1]
    again = synth.interpolate(list(pair), [torch.full((SIZE, SIZE), time) for time in (0.0, 0.5, 0.5, 1.0)], **QUICK)
    assert all(torch.equal(again.frames[at], frame) for at, frame in zip((0, 1, 3), made.frames, strict=True))
    assert again.frames[1] is not again.frames[0]
    assert torch.equal(again.frames[1], again.frames[2])
    assert again.remarks == made.remarks


def test_detail_is_fainter_when_blurred(pair: tuple[torch.Tensor, torch.Tensor]) -> None:
    assert strength(pair[1], pair, (0.0, 1.0)) == pytest.approx(1, abs=0.01)
    assert strength(avg_pool2d(pair[1], 9, 1, 4), pair, (0.0, 1.0)) < 0.8


def test_same_seed_same_bits_for_any_number_of_threads(pair: tuple[torch.Tensor, torch.Tensor]) -> None:
    found = []
    for count in (1, 2):
        torch.set_num_threads(count)
        found.append(synth.morph(*pair, [0.4, 0.6], method="patches", **QUICK).frames)
    assert all(torch.equal(x, y) for x, y in zip(*found, strict=True))


def test_identical_textures_stay_that_texture(pair: tuple[torch.Tensor, torch.Tensor]) -> None:
    a, _ = pair
    made = synth.morph(a, a, 4, method="patches", **QUICK)
    assert all(float((frame - a).abs().max()) < 0.001 for frame in made.frames)
    assert float((synth.interpolate([a, a], (0.3, 0.7), **QUICK).image - a).abs().max()) < 0.001
    large = synth.interpolate([a, a], (0.3, 0.7), size=(SIZE, 80), **QUICK).image
    assert torch.allclose(large, synth.synthesize(a, (SIZE, 80), preset="fast").image, atol=1e-5)


def test_the_ends_are_textures_of_a_and_b(pair: tuple[torch.Tensor, torch.Tensor]) -> None:
    for number, texture in enumerate(pair):
        half = SIZE // 2
        floor = (sliced(texture[:, :half], texture[:, half:]) + sliced(texture[..., :half], texture[..., half:])) / 2
        made = synth.interpolate(list(pair), (1 - number, number), size=(40, 72), **QUICK).image
        assert sliced(made, texture) < floor
        assert sliced(made, pair[1 - number]) > 2 * floor


@pytest.mark.parametrize("times", [[0.5], [0.0, 0.5, 1.0]])
def test_any_size_and_tiles(times: list[float], pair: tuple[torch.Tensor, torch.Tensor]) -> None:
    made = synth.morph(*pair, times, method="patches", size=(40, 72), tile=True, **QUICK)
    frame = made.frames[len(times) // 2]
    assert frame.shape == (3, 40, 72)
    inside = (frame[:, :, 1:] - frame[:, :, :-1]).abs().mean()
    assert float((frame[:, :, 0] - frame[:, :, -1]).abs().mean()) < 2 * float(inside)


def test_a_map_is_kept(pair: tuple[torch.Tensor, torch.Tensor]) -> None:
    a, b = pair
    ramp = torch.linspace(0, 1, 72).expand(40, -1)
    made = synth.interpolate([a, b], [ramp], **QUICK)
    assert made.image.shape == (3, 40, 72)
    left, right = colors(made.image[:, :, :16]), colors(made.image[:, :, -16:])
    assert float((left - colors(a)).abs().max()) < 0.06
    assert float((right - colors(b)).abs().max()) < 0.06
    assert len(made.features) == 2


@pytest.mark.parametrize("faint", [passage.FAINT, 9.0])
def test_where_a_map_stays_so_does_the_film(
    pair: tuple[torch.Tensor, torch.Tensor], monkeypatch: pytest.MonkeyPatch, faint: float
) -> None:
    monkeypatch.setattr(passage, "FAINT", faint)  # at 9 textures cancel each other
    maps = [torch.zeros(SIZE, 112), torch.zeros(SIZE, 112), torch.zeros(SIZE, 112)]
    maps[2][:, 80:] = 1
    first, second, third = synth.interpolate(list(pair), maps, **QUICK).frames
    assert torch.equal(first, second)
    assert torch.equal(first[:, :, :56], third[:, :, :56])
    assert float((colors(third[:, :, 88:]) - colors(pair[1])).abs().max()) < 0.08


def test_the_maps_of_a_film_are_looked_at_one_by_one(pair: tuple[torch.Tensor, torch.Tensor]) -> None:
    class Maps(list[weakref.ref[torch.Tensor]]):
        alive = 0

        def __getitem__(self, number: Any) -> Any:
            made = torch.full((SIZE, SIZE), float(number == 5))
            self.append(weakref.ref(made))
            Maps.alive = max(Maps.alive, sum(each() is not None for each in self))
            return made

        def __len__(self) -> int:
            return 6

    frames = synth.interpolate(list(pair), Maps(), **QUICK).frames
    assert [float(frame.sub(pair[0]).abs().max()) < 1e-4 for frame in frames] == [True] * 5 + [False]
    assert Maps.alive <= 2


def test_three_textures_in_equal_parts(pair: tuple[torch.Tensor, torch.Tensor]) -> None:
    third = spots(SIZE, 2, 0.5)
    made = synth.interpolate([*pair, third], (1, 1, 1), size=(SIZE, SIZE), **QUICK)
    expected = torch.stack([colors(image) for image in (*pair, third)]).mean(0)
    assert float((colors(made.image) - expected).abs().max()) < 0.03
    alone = synth.interpolate([*pair, third], (0, 0, 2), **QUICK)
    assert torch.allclose(alone.image, third, atol=1e-6)


def tiles(period: int, seed: int, size: int = 80) -> torch.Tensor:
    """Tiles of several tones with dark joints."""
    line = torch.arange(size)
    joint = (line % period < 2)[:, None] | (line % period < 2)[None]
    tones = 0.5 + 0.4 * torch.rand(1, 12, 12, generator=torch.Generator().manual_seed(seed))
    return torch.where(joint, 0.1, tones[:, (line // period)[:, None], (line // period)[None]])


def likeliest_period(image: torch.Tensor) -> float:
    """By how many px, between whole ones, an image (1, H, W) is most like itself along its columns, of 7 to 15."""
    apart = (image - image.mean())[0]
    alike = [float((apart[shift:] * apart[:-shift]).mean()) for shift in range(6, 17)]
    best = max(range(1, 10), key=alike.__getitem__)
    before, most, after = alike[best - 1 : best + 2]
    return 6 + best + (before - after) / (before - 2 * most + after) / 2


def test_elements_of_a_film_grow_from_frame_to_frame() -> None:
    a, b = tiles(8, 0), tiles(14, 1)
    frames = synth.morph(a, b, 4, method="patches", **QUICK).frames
    assert torch.allclose(frames[0], a, atol=1e-6)
    assert torch.allclose(frames[-1], b, atol=1e-6)
    periods = [likeliest_period(frame) for frame in frames]
    assert periods == pytest.approx([8 * (14 / 8) ** (number / 3) for number in range(4)], abs=0.5)


def test_a_film_that_tiles_does_not_zoom() -> None:
    a, b = tiles(8, 0), tiles(16, 1)
    frames = synth.morph(a, b, 2, method="patches", tile=True, **QUICK).frames
    assert torch.allclose(frames[1], b, atol=1e-6)


def test_elements_of_a_still_have_a_size_in_between() -> None:
    made = synth.interpolate([tiles(8, 0), tiles(14, 1)], (0.5, 0.5), **QUICK).image
    assert 9.5 < element_size(Exemplar.of(made)) < 12.5  # 8.5 and 14.6 are the textures' own
    apart = (made - made.mean())[0]
    alike = [float((apart * apart.roll(shift, 1)).mean()) for shift in (8, 10, 14)]
    assert alike[1] == max(alike)  # one lattice, not two that are laid over each other


def test_elements_of_a_map_grow_along_it() -> None:
    ramp, middles = torch.linspace(0, 1, 192).expand(56, -1), (20, 60, 96, 128, 172)
    made = synth.interpolate(
        [tiles(8, 0), tiles(14, 1)], [ramp], preset="fast"
    ).image  # of few anchors they grow at once, halfway
    periods = [likeliest_period(made[:, :, middle - 20 : middle + 20]) for middle in middles]
    # rows of a strip of 56 px end where their number falls, so that their height grows by steps
    assert periods == pytest.approx([8 * (14 / 8) ** (middle / 192) for middle in middles], abs=1)


def test_a_map_made_as_published_keeps_the_grain_of_textures_where_they_are_nearly_alone() -> None:
    a, b = (torch.rand(1, SIZE, SIZE, generator=torch.Generator().manual_seed(seed)) for seed in range(2))
    ramp = torch.linspace(0, 1, 96).expand(40, -1)
    made = synth.interpolate([a, b], [ramp], preset="fast", independent=True).image
    assert unlike(made[:, :, :12], a) < 0.5  # 0.65 where windows are averaged and made as strong again
    assert unlike(made[:, :, -12:], b) < 0.5


def test_a_map_that_fades_is_made_as_published_and_one_that_jumps_is_led(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Interpolation, "passage", Mock(cancels=False))
    monkeypatch.setattr(Interpolation, "published", lambda self, weighting: Frame(self.images[0], weighting))
    monkeypatch.setattr(Interpolation, "led", lambda self, weighting: Frame(self.images[1], weighting))
    textures, steps = [torch.zeros(1, SIZE, SIZE), torch.ones(1, SIZE, SIZE)], torch.arange(SIZE).expand(SIZE, -1)
    for weights, way in (((0.5, 0.5), 0), ([steps / SIZE], 0), ([0.8 - 0.6 * (steps > 20)], 1)):
        assert torch.equal(synth.interpolate(textures, weights, even=False, **QUICK).image, textures[way])


def test_levels_whose_windows_see_a_map_change_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Interpolation, "_matched", lambda self, level: level)
    between = PatchMorph(Making(scaled=False)).between((tiles(8, 0), tiles(8, 1)), None, (72, 800), False, 0)
    assert between.levels(Weighting.even((0.5, 0.5), (72, 800))) == PUBLISHED
    for length, kept in ((800, 3), (500, 2), (200, 1)):
        ramp = torch.linspace(0, 1, length).expand(72, -1)
        assert between.levels(Weighting.of(torch.stack([1 - ramp, ramp]))) == PUBLISHED[-kept:]


def unlike(image: torch.Tensor, texture: torch.Tensor) -> float:
    """How much 5x5 windows of an image (1, H, W) differ from the nearest of a texture, in the texture's variance."""
    windows, known = (each.unfold(1, 5, 1).unfold(2, 5, 1).reshape(-1, 25) for each in (image, texture))
    return float(torch.cdist(windows, known).amin(1).square().mean() / 25 / texture.var())


def test_where_a_map_has_textures_of_other_scale_alone_they_stay_themselves() -> None:
    a, b = tiles(8, 0), tiles(14, 1)
    mask = torch.zeros(80, 80)
    mask[:, 40:] = 1
    made = synth.interpolate([a, b], [mask], **QUICK).image
    assert torch.allclose(made[:, :, :20], a[:, :, :20], atol=1e-6)
    assert torch.allclose(made[:, :, -20:], b[:, :, -20:], atol=1e-6)


def test_a_still_is_made_as_published_and_as_strong_at_its_border_as_inside() -> None:
    a, b = (torch.rand(1, SIZE, SIZE, generator=torch.Generator().manual_seed(seed)) for seed in range(2))
    made = synth.morph(a, b, [0.5], method="patches", **QUICK).frames[0]
    assert torch.equal(made, synth.morph(a, b, [0.5], method="patches", independent=True, **QUICK).frames[0])
    detail = made - avg_pool2d(made, 3, 1, 1, count_include_pad=False)
    outermost = torch.ones(SIZE, SIZE, dtype=torch.bool)
    outermost[3:-3, 3:-3] = False
    assert float(detail[:, outermost].std() / detail[:, ~outermost].std()) == pytest.approx(1, abs=0.1)


def test_given_features_are_used_and_arrays_of_bytes_come_back_as_such(
    pair: tuple[torch.Tensor, torch.Tensor],
) -> None:
    marks = torch.zeros(SIZE, SIZE)
    marks[::8] = 1
    images = [(image * 255).byte().permute(1, 2, 0).numpy() for image in pair]
    made = synth.interpolate(images, (1, 1), features=[marks.numpy(), marks.numpy()], **QUICK)
    assert isinstance(made.image, np.ndarray)
    assert made.image.dtype == np.uint8
    assert made.image.shape == (SIZE, SIZE, 3)
    assert np.array_equal(made.features[0], marks.numpy() > 0.5)
    assert made.remarks == ("features were given",)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"weights": (1, 2, 3)}, "give 2"),
        ({"weights": (1, -1)}, "from 0 on"),
        ({"weights": ()}, "no weights"),
        ({"weights": [torch.full((SIZE, SIZE), 1.5)]}, "0 to 1"),
        ({"weights": [torch.ones(3, SIZE, SIZE)]}, "channel per texture"),
        ({"weights": [torch.ones(2, 8, 8)]}, "only 8 px"),
        ({"weights": [torch.ones(2, SIZE, SIZE), torch.ones(2, SIZE, 40)]}, "differ in size"),
        ({"features": [torch.zeros(SIZE, SIZE)] * 2}, "empty"),
        ({"features": [torch.ones(SIZE, SIZE)] * 2}, "full"),
        ({"features": [torch.ones(SIZE, SIZE)]}, "one for each"),
        ({"textures": [spots(SIZE, 0, 0.9)]}, "at least two"),
        ({"textures": [spots(SIZE, 0, 0.9), spots(SIZE, 0, 0.9)[:1]]}, "channels"),
        ({"textures": [spots(12, 0, 0.9)] * 2}, "12 px"),
        ({"size": (8, 8)}, "8 px"),
        ({"search": "long"}, "allowed are fast"),
    ],
)
def test_what_will_not_do_is_said(change: dict[str, Any], said: str, pair: tuple[torch.Tensor, torch.Tensor]) -> None:
    given: dict[str, Any] = {"textures": list(pair), "weights": (0.5, 0.5)} | QUICK | change
    with pytest.raises(InputError, match=said):
        synth.interpolate(given.pop("textures"), given.pop("weights"), **given)
