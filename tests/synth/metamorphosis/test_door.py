"""What `synth.morph` takes and gives, and what it refuses."""

import numpy as np
import pytest
import torch
from pictures import disc, spots

import synth
from kwatra import InputError
from synth.metamorphosis.method import Frames, Pair
from synth.metamorphosis.pairing import Growth


def color(seed: int, size: int = 24) -> torch.Tensor:
    return spots(size, seed, 0.6)


def test_eleven_frames_are_made_where_nothing_is_said():
    assert len(synth.morph(color(0), color(1), method="blend").frames) == 11


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_frames_are_of_the_kind_of_the_images(dtype):
    most = 1000.0 if dtype == np.float32 else np.iinfo(dtype).max
    a, b = ((color(s).permute(1, 2, 0).numpy() * most).astype(dtype) for s in (0, 1))
    made = synth.morph(a, b, 3, method="blend")
    assert all(frame.dtype == dtype and frame.shape == (24, 24, 3) for frame in made.frames)
    np.testing.assert_allclose(made.frames[0], a, rtol=1e-5, atol=1e-3)
    np.testing.assert_allclose(made.frames[2], b, rtol=1e-5, atol=1e-3)
    middle = (a.astype(float) + b) / 2
    np.testing.assert_allclose(made.frames[1], middle, atol=0.51 if dtype != np.float32 else 1e-2)


def test_gray_is_made_color_and_sizes_are_cropped_and_both_are_said():
    made = synth.morph(color(0)[:1, :20], color(1)[:, :, :18], 3, method="blend")
    assert made.frames[0].shape == (3, 20, 18)
    torch.testing.assert_close(made.frames[0], color(0)[:1, :20, :18].expand(3, -1, -1))
    assert made.remarks == (
        "A is gray and was made color like the other",
        "A is 24x20 and B 18x24, both were cropped to 18x20",
    )
    flat = color(0)[0].numpy()
    assert synth.morph(flat, color(1).permute(1, 2, 0).numpy(), 2, method="blend").frames[0].shape == (24, 24, 3)


def test_times_are_those_asked_for():
    assert synth.morph(color(0), color(1), 3, method="blend").times == (0.0, 0.5, 1.0)
    made = synth.morph(color(0), color(1), [0.25], method="blend")
    assert made.times == (0.25,)
    torch.testing.assert_close(made.frames[0], 0.75 * color(0) + 0.25 * color(1))


def test_any_size_is_synthesized_first():
    told = []
    made = synth.morph(
        color(0, 40), color(1, 40), 3, method="blend", size=(48, 56), preset="fast", callback=lambda *a: told.append(a)
    )
    assert all(frame.shape == (3, 48, 56) for frame in made.frames)
    parts = [part for _, part in told]
    assert parts == sorted(parts)
    assert 0 < parts[0] <= parts[-1] <= 1
    assert any("B where A's features lie" in what for what, _ in told)


def test_bs_features_then_lie_where_as_do():
    """A dark and a light half in each, marked: at the new size B's light half is to lie over A's."""
    down = torch.arange(48)[:, None].expand(48, 48) < 24
    across = down.T.contiguous()
    noise = 0.1 * torch.rand(2, 1, 48, 48, generator=torch.Generator().manual_seed(0))
    a, b = down.float()[None] * 0.5 + noise[0], across.float()[None] * 0.5 + noise[1]
    made = synth.morph(a, b, 2, method="control", size=(64, 64), features=(down, across), preset="fast")
    light_a, light_b = (frame[0] > 0.35 for frame in made.frames)
    assert float((light_a == light_b).float().mean()) > 0.85


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"method": "magic"}, "the method is 'magic'; allowed are control, registration, blend"),
        ({"method": "blend", "alpha": 1.0}, "the method 'blend' has no option 'alpha'; it takes none"),
        ({"method": "control", "alhpa": 1.0}, "has no option 'alhpa'; it takes alpha, gamma, steps"),
        ({"preset": "quick"}, "the preset is 'quick'; allowed are fast, default, best"),
        ({"times": 1}, "the number of frames is 1; give at least 2"),
        ({"times": [0.5, 2]}, "each from 0"),
        ({"times": []}, "at least one"),
        ({"times": 3.5}, "times are 3.5; give a number of frames"),
        ({"times": None}, "times are None"),
        ({"times": [0.5, 0.2]}, "give them in order"),
        ({"size": (8, 40)}, "at least 17 px"),
        ({"size": (8, 40), "method": "blend"}, "at least 16 px"),
        ({"method": "blend", "features": (torch.ones(24, 24), torch.ones(24, 24))}, "takes no features; those that do"),
        ({"features": (torch.ones(24, 24), torch.ones(20, 24))}, "B's features have shape .1, 20, 24., but B is 24x24"),
        ({"features": (torch.ones(24, 24),)}, "1 maps of features were given; give A's and B's"),
        ({"features": (torch.ones(2, 24, 24), torch.ones(24, 24))}, "give the same number"),
        ({"features": (torch.full((24, 24), torch.nan), torch.ones(24, 24))}, "A's features hold NaN"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(arguments, sentence):
    arguments = {"times": 3, "preset": "fast", **arguments}
    with pytest.raises(InputError, match=sentence):
        synth.morph(color(0), color(1), **arguments)


@pytest.mark.parametrize(
    ("a", "b", "sentence"),
    [
        (color(0), color(1)[:2], "A has 3 channels and B 2; give both the same"),
        (color(0), color(1)[:, :10], "A and B have 24x10 px in common; give textures of at least 16x16"),
        (color(0), torch.full((3, 24, 24), torch.nan), "NaN"),
        (color(0), color(1).numpy(), "all of one kind"),
        (color(0), torch.ones(24), "of shape"),
    ],
)
def test_images_that_cannot_be_are_refused(a, b, sentence):
    with pytest.raises(InputError, match=sentence):
        synth.morph(a, b, method="blend")


def test_options_are_told_once_each():
    with pytest.raises(InputError) as refusal:
        synth.morph(color(0), color(1), method="patches", alpha=1.0)
    told = str(refusal.value).split("it takes ")[1].split(", ")
    assert {"feature_weight", "rejected", "map_weight"} <= set(told)
    assert len(told) == len(set(told))


def test_registration_moves_each_way_and_dissolves():
    a, b, truth = (disc(36, x, 18, 6) for x in (14, 22, 18))
    made = synth.morph(a, b, 3, method="registration", sigma=0.05)
    error = float((made.frames[1] - truth).abs().mean())
    assert error < 0.3 * float(((a + b) / 2 - truth).abs().mean())
    assert float(made.film.velocity.sum(0)[0, 18, 14]) == pytest.approx(8, abs=2)


def test_frames_looked_at_once_are_made_once_and_not_kept() -> None:
    made: list[int] = []
    frames = Frames((made.append(number) or number for number in range(4)), 4)
    assert frames[0] == 0
    passing = frames.once()
    assert [next(passing), next(passing)] == [0, 1]
    assert made == [0, 1]
    assert list(passing) == [2, 3]
    assert made == [0, 1, 2, 3]
    assert frames._made == [0]


def test_videos_are_refused():
    clip = color(0)[:, None].expand(-1, 4, -1, -1)
    with pytest.raises(InputError, match="A and B are videos; give images"):
        synth.morph(clip, clip, 3, method="blend")


def test_of_two_textures_that_are_synthesized_each_is_half_of_the_work():
    told: list[tuple[str, float]] = []
    Growth("fast", 0, "cpu")(Pair(color(0), color(1)), (32, 40), lambda *progress: told.append(progress))
    parts = {what: [part for name, part in told if name == what] for what, _ in told}
    assert list(parts) == ["synthesizing A", "synthesizing B where A's features lie"]
    (first, second) = parts.values()
    assert first == sorted(first)
    assert second == sorted(second)
    assert 0 <= first[0] <= first[-1] == 0.5 < second[0] <= second[-1] == 1
