"""A drawing's tones, shown by what of a texture is light and dark."""

import numpy as np
import pytest
import torch
from made import MADE
from scipy.ndimage import gaussian_filter

from kwatra import Exemplar
from kwatra.pieces import hidden_seams
from synth import InputError, synthesize
from synth.texture import tones


def dunes(size: int = 96) -> np.ndarray:
    """Stripes of one contrast whose tones rise and fall slowly, uint8."""
    y, x = np.mgrid[:size, :size]
    light = 128 + 60 * np.sin(x * 2 * np.pi / size)
    return (light + np.where((x + y) % 8 < 4, 30, -30)).astype(np.uint8)


def contrast(image: np.ndarray) -> float:
    return float((image - gaussian_filter(image.astype(float), 4)).std())


def test_the_texture_is_as_light_and_dark_as_the_drawing_and_no_flatter() -> None:
    wanted = np.repeat(np.linspace(80, 176, 80)[None].astype(np.uint8), 80, 0)
    made = synthesize(dunes(), guide=tones(dunes(), wanted), guide_weight=0.3, preset="fast").image
    seen = gaussian_filter(made.astype(float), 6)[10:-10, 10:-10].mean(0)
    slope = np.polyfit(wanted[0, 10:-10], seen, 1)[0]
    assert 0.75 < slope < 1.25
    assert contrast(made) > 0.9 * contrast(dunes())


def test_an_image_is_seen_blurred_and_a_drawing_in_gray_as_far_as_there_are_tones() -> None:
    colors, drawing = torch.rand(3, 30, 40), torch.rand(3, 20, 24)
    (own,), wanted = tones(colors, drawing)
    expected = gaussian_filter(colors.double().mean(0).numpy(), 8, mode="nearest")
    torch.testing.assert_close(own[0].numpy(), expected.astype(np.float32))
    low, high = np.quantile(expected, (0.1, 0.9))
    torch.testing.assert_close(wanted, drawing.mean(0, keepdim=True).clamp(low, high))
    (rows,), columns = tones(colors.permute(1, 2, 0).numpy(), drawing[0].numpy())
    assert (rows.shape, columns.shape) == ((30, 40, 1), (20, 24, 1))
    np.testing.assert_allclose(rows[..., 0], own[0].numpy(), atol=1e-6)


def test_elements_are_seen_as_wholes() -> None:
    coins = MADE["coins"](160, 40, 0).image
    (own,), _ = tones(coins, coins)
    reach = 0.5 * hidden_seams(Exemplar.of(coins)).size
    assert 14 < reach < 26
    expected = gaussian_filter(coins.double().mean(0).numpy(), reach, mode="nearest")
    torch.testing.assert_close(own[0].numpy(), expected.astype(np.float32), atol=1e-3, rtol=0)
    (bytes_,), _ = tones((coins * 255).round().byte(), (coins * 255).round().byte())
    torch.testing.assert_close(bytes_ / 255, own, atol=5e-3, rtol=0)


def test_several_exemplars_have_all_their_tones() -> None:
    dark, light = torch.full((1, 20, 20), 0.2), torch.full((1, 30, 20), 0.7)
    maps, wanted = tones([dark, light], torch.linspace(0, 1, 50).expand(1, 10, 50))
    assert [each.shape for each in maps] == [(1, 20, 20), (1, 30, 20)]
    assert (float(wanted.min()), float(wanted.max())) == pytest.approx((0.2, 0.7))


def test_a_video_has_the_tones_of_each_frame() -> None:
    clip = torch.rand(3, 4, 30, 40)
    (own,), wanted = tones(clip, clip)
    assert own.shape == wanted.shape == (1, 4, 30, 40)
    torch.testing.assert_close(own[:, 2], tones(clip[:, 2], clip[:, 2])[0][0])


def test_an_array_and_a_tensor_are_no_guide() -> None:
    with pytest.raises(InputError, match="tones are wanted of an array and a tensor"):
        tones(np.zeros((8, 8)), torch.zeros(1, 8, 8))
