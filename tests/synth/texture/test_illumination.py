"""Light that falls unevenly on a still is found and taken out, and light that is even is left alone."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch
from skimage import data
from torch import Tensor

from kwatra import Exemplar, SoftPixels
from synth import fill, synthesize
from synth.texture import illumination
from synth.texture.asked import Asked
from synth.texture.form import Form
from synth.texture.illumination import find_light, under_even_light
from synth.texture.work import Work

SIDE = 128
EVEN = {"brick": data.brick(), "gravel": data.gravel(), "grass": data.grass()}


def texture(name: str) -> np.ndarray:
    """An evenly lit texture (SIDE, SIDE), 0 to 1, 0 where no light is."""
    return EVEN[name][:SIDE, :SIDE] / 255


def gradient() -> np.ndarray:
    """Light that grows to the right, 1 on average."""
    return np.linspace(0.6, 1.4, SIDE)[None].repeat(SIDE, 0)


def vignette() -> np.ndarray:
    """Light that falls off from the middle."""
    down, right = np.indices((SIDE, SIDE)) / (SIDE / 2) - 1
    return 1 - 0.35 * (down**2 + right**2)


def shadow() -> np.ndarray:
    """Light beside a soft shadow."""
    down, right = np.indices((SIDE, SIDE)) / SIDE
    return 0.5 + 0.5 / (1 + np.exp((1 - down - right) / 0.18))


def picture(values: np.ndarray) -> Tensor:
    return torch.from_numpy(values).float()[None]


def everywhere(shape: tuple[int, ...] = (SIDE, SIDE)) -> Tensor:
    return torch.ones(shape, dtype=torch.bool)


@pytest.mark.parametrize("light", [gradient, vignette, shadow])
@pytest.mark.parametrize("name", EVEN)
def test_light_that_times_a_texture_is_found_and_taken_out(name: str, light: Callable[[], np.ndarray]) -> None:
    lit = picture(texture(name) * light() / light().max())
    found = find_light(lit, 0.0, everywhere())
    assert found is not None
    assert found.times
    truth = np.log(light()) - np.log(light()).mean()
    rest = found.field.numpy() - found.field.numpy().mean() - truth
    assert rest.std() < 0.3 * truth.std()
    assert found.without(lit).mean() == pytest.approx(float(lit.mean()), rel=0.01)
    assert torch.allclose(found.upon(found.without(lit)), lit, atol=0.02)


@pytest.mark.parametrize("name", EVEN)
def test_light_that_is_added_is_told_from_light_that_times(name: str) -> None:
    gloss = 0.5 * (gradient() - 0.6)
    found = find_light(picture(0.6 * texture(name) + gloss), 0.0, everywhere())
    assert found is not None
    assert not found.times
    assert np.abs(found.field.numpy() - (gloss - gloss.mean())).max() < 0.08


def test_letters_on_paper_in_shadow_stay_black() -> None:
    page = picture(data.page() / 255)
    found = find_light(page, 0.0, everywhere((191, 384)))
    assert found is not None
    assert found.times
    left, right = (found.without(page)[0, :, part].quantile(0.03) for part in (slice(128), slice(256, None)))
    assert float(left) == pytest.approx(float(right), abs=0.1)  # .17 more where light was added


def test_light_falls_on_all_colors_and_a_thing_of_another_color_is_none() -> None:
    def under(red: float, green: float, blue: float) -> Tensor:
        light = vignette() / vignette().max()
        return torch.cat([picture(texture("gravel") * light**power) for power in (red, green, blue)])

    assert find_light(under(1, 1, 1), 0.0, everywhere()) is not None
    assert find_light(under(0.8, 1, 1.2), 0.0, everywhere()) is not None
    assert find_light(under(0.4, 1, 1.4), 0.0, everywhere()) is None
    assert find_light(under(-0.5, 1.5, 1.5), 0.0, everywhere()) is None


@pytest.mark.parametrize("name", EVEN)
def test_even_light_is_told_from_uneven_with_a_margin(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    exemplar = Exemplar.of(picture(EVEN[name] / 255))
    lit = picture(texture(name) * gradient() / 1.4)
    assert under_even_light(exemplar, 0.0) is exemplar
    monkeypatch.setattr(illumination, "BELIEVED", illumination.BELIEVED / 2)
    assert under_even_light(exemplar, 0.0) is exemplar
    monkeypatch.setattr(illumination, "BELIEVED", illumination.BELIEVED * 4)
    assert find_light(lit, 0.0, everywhere()) is not None


def test_large_stones_of_many_tones_keep_them() -> None:
    tones = np.random.default_rng(0).random((6, 6)) * 0.7 + 0.2
    stones = np.kron(tones, np.ones((24, 24))) * (1 - 0.5 * (np.indices((144, 144)) % 24 < 3).any(0))
    assert find_light(picture(stones), 0.0, everywhere((144, 144))) is None


def test_what_may_be_no_color_or_is_small_or_of_one_color_is_left_alone() -> None:
    lit = picture(texture("brick") * gradient() / 1.4)
    for other in (lit.expand(4, -1, -1), lit.expand(2, -1, -1), torch.full_like(lit, 0.5), torch.zeros_like(lit)):
        assert find_light(other, 0.0, everywhere()) is None
    small = lit[:, : illumination.LEAST - 1]
    assert find_light(small, 0.0, everywhere(tuple(small.shape[1:]))) is None
    clip = lit[:, None].expand(-1, 80, -1, -1)
    assert find_light(clip, 0.0, everywhere((80, SIDE, SIDE))) is None


@pytest.mark.parametrize("colors", [1, 3])
def test_light_falls_on_the_colors_of_what_is_opaque(colors: int) -> None:
    lit = picture(texture("brick") * gradient() / 1.4).expand(colors, -1, -1)
    plain, known = find_light(lit, 0.0, everywhere()), everywhere()
    opaque = torch.cat([lit, torch.ones(1, SIDE, SIDE)])
    found = find_light(opaque, 0.0, everywhere())
    assert plain is not None
    assert found is not None
    assert torch.equal(found.field, plain.field)
    assert torch.equal(found.without(opaque), torch.cat([plain.without(lit), torch.ones(1, SIDE, SIDE)]))
    opaque[-1, :10] = 0.5
    assert find_light(opaque, 0.0, known) is None
    known[:10] = False
    assert find_light(opaque, 0.0, known) is not None


def test_what_is_not_known_has_no_influence() -> None:
    lit, known = picture(texture("gravel") * gradient() / 1.4), everywhere()
    known[30:70, 50:100] = False
    found = find_light(lit, 0.0, known)
    other = find_light(torch.where(known, lit, 1.0), 0.0, known)
    whole = find_light(lit, 0.0, everywhere())
    assert found is not None
    assert other is not None
    assert whole is not None
    assert torch.equal(found.field, other.field)
    assert (found.field - whole.field).abs().max() < 0.15


@pytest.mark.parametrize("name", EVEN)
def test_light_goes_on_into_what_is_not_known_without_leaps(name: str) -> None:
    bright = 1 + 0.7 * (np.indices((256, 256)).sum(0) / 256 - 1)
    known = everywhere((256, 256))
    known[:, :128] = False
    found = find_light(picture(EVEN[name][:256, :256] / 255 * bright / bright.max()), 0.0, known)
    assert found is not None
    rest = found.field.numpy() - np.log(bright)
    rest -= rest[:, 128:].mean()
    assert np.square(rest[:, 128:]).mean() ** 0.5 < 0.07
    assert np.square(rest[:, :128]).mean() ** 0.5 < 0.8 * np.log(bright).std()


def test_light_times_what_values_are_above_black() -> None:
    light = 200 * texture("brick") * gradient() / 1.4 + 20
    form = Form.of([light.astype(np.uint8)])
    assert form.black == pytest.approx(form.low / (form.high - form.low))
    assert Form.of([light - 100]).black == 0
    dark = find_light(form.normalized(light.astype(np.uint8)), form.black, everywhere())
    assert dark is not None


def test_variants_of_an_exemplar_lose_the_light_of_their_own_places() -> None:
    lit, allowed = picture(texture("gravel") * gradient() / 1.4), everywhere()
    allowed[:8], allowed[:, :16] = False, False
    plain = under_even_light(Exemplar.of(lit, masks=[allowed]), 0.0).pictures()[0]
    made = under_even_light(Exemplar.of(lit, masks=[allowed], mirror=True), 0.0)
    mirrored = made.canvas[:, made.owner == 1].view(plain.shape)
    assert torch.equal(made.pictures()[0], plain)
    assert torch.equal(mirrored, plain.flip(-1))
    bright = plain.mean(1)[0]
    assert bright[:40].mean() == pytest.approx(float(bright[-40:].mean()), rel=0.15)


def test_a_still_of_an_unevenly_lit_exemplar_is_lit_evenly_and_takes_maps() -> None:
    lit = (255 * texture("gravel") * gradient() / 1.4).round().astype(np.uint8)
    made = synthesize(lit, (160, 160), preset="fast")
    assert made.image.dtype == np.uint8
    assert lit.min() <= made.image.min()
    assert made.image.max() <= lit.max()
    assert made.image.mean() == pytest.approx(lit.mean(), rel=0.08)
    blocks = made.image.reshape(4, 40, 4, 40).mean((1, 3))
    assert blocks.std() < 0.12 * blocks.mean()  # without, .17 and more
    places = np.indices(lit.shape)
    assert np.array_equal(made.take(places[1]), made.source[2])
    (even,) = made.even
    assert even.dtype == np.uint8
    assert even[:, :40].mean() == pytest.approx(even[:, -40:].mean(), rel=0.1)
    assert not synthesize(EVEN["gravel"][:SIDE, :SIDE], (80, 80), preset="fast").even


def test_what_is_asked_for_besides_keeps_the_light_it_may_mean() -> None:
    lit = picture(texture("gravel") * gradient() / 1.4)
    form = Form.of([lit])
    given = Exemplar.of(form.normalized(lit)).canvas
    wish = SoftPixels(torch.zeros(1, SIDE, SIDE), torch.ones(1, SIDE, SIDE))
    asked, wishes = Asked.of(lit, (SIDE, SIDE)), list[dict[str, Any]]([{"terms": wish}, {"start": lit}, {"stay": 0.5}])
    works = [Work.of(Asked.of(lit, None, (lit, lit))), *(Work.of(asked, **meant) for meant in wishes)]
    assert all(torch.equal(work.source.canvas[:1], given) for work in works)
    assert not torch.equal(Work.of(asked, tile=True).source.canvas, given)


@pytest.mark.parametrize("elsewhere", [False, True])
def test_a_hole_is_filled_under_the_light_around_it(elsewhere: bool) -> None:
    whole = (255 * texture("grass") * gradient() / 1.4).round().astype(np.uint8)
    hole = np.zeros(whole.shape, bool)
    hole[44:84, 4:44] = hole[44:84, 84:124] = True
    other = [(255 / 1.4 * texture("grass")[::-1, ::-1]).astype(np.uint8)] if elsewhere else None
    filled = fill(whole, hole, exemplar=other, preset="fast").image
    assert np.array_equal(filled[~hole], whole[~hole])
    for part in (slice(4, 44), slice(84, 124)):
        around = (whole[14:44, part].mean() + whole[84:114, part].mean()) / 2
        assert filled[44:84, part].mean() == pytest.approx(around, rel=0.15)
