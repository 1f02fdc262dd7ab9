"""Settings for textures that move."""

import pytest
import torch

from kwatra import Decisive, Exemplar, Settings
from synth.texture.moving import HIDDEN, NOTICED, change, in_time, undone


def test_what_changes_is_known_and_only_what_belongs_to_one_clip_counts():
    clip = torch.zeros(2, 4, 16, 16)
    clip[0, 1::2] = 0.3  # of two channels one changes by .3 a frame
    assert change(Exemplar.of(clip)) == pytest.approx((0.3**2 / 2) ** 0.5, rel=1e-5)
    other = torch.ones(2, 4, 16, 16)
    assert change(Exemplar.of([clip, other])) == pytest.approx((0.3**2 / 4) ** 0.5, rel=1e-5)
    hole = torch.ones(4, 16, 16, dtype=torch.bool)
    hole[:, :8] = False
    clip[0, :, :8] = torch.rand(4, 8, 16, generator=torch.Generator().manual_seed(0))
    assert change(Exemplar.of(clip, masks=[hole])) == pytest.approx((0.3**2 / 2) ** 0.5, rel=1e-5)


def test_a_single_frame_has_no_change_and_is_averaged():
    still = Exemplar.of(torch.rand(1, 1, 16, 16, generator=torch.Generator().manual_seed(0)))
    assert in_time(Settings(), still).vote == Decisive(0.0)


def test_what_has_no_memory_changes_back_and_what_moves_on_does_not():
    generator = torch.Generator().manual_seed(0)
    noise = torch.rand(2, 40, 24, 24, generator=generator)
    assert undone(Exemplar.of(noise)) == pytest.approx(1.0, abs=0.05)
    ramp = torch.rand(2, 1, 24, 24, generator=generator) * torch.arange(1.0, 6).view(-1, 1, 1)
    assert undone(Exemplar.of(ramp)) == 0.0
    walk = torch.randn(1, 200, 16, 16, generator=generator).cumsum(1)
    assert undone(Exemplar.of(walk)) == pytest.approx(0.0, abs=0.03)
    assert undone(Exemplar.of(noise[:, :2])) == 0.0
    assert undone(Exemplar.of([noise[:, 2 * t : 2 * t + 2] for t in range(20)])) == 0.0  # no clip of three frames


def test_the_tolerance_follows_the_clip():
    clip = torch.zeros(1, 3, 16, 16)
    clip[0, 1] = 0.4
    settings = in_time(Settings(seams=2), Exemplar.of(clip))
    assert settings.vote.tolerance == pytest.approx(0.4 * NOTICED * (1 + HIDDEN), rel=1e-5)  # all changes back
    assert settings.seams == 2
