"""Settings for textures that move."""

import pytest
import torch

from kwatra import Blocks, Decisive, Exemplar, Settings
from synth.texture.moving import NOTICED, change, in_time


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


def test_the_tolerance_follows_the_clip():
    clip = torch.zeros(1, 3, 16, 16)
    clip[0, 1] = 0.4
    assert in_time(Settings(blocks=Blocks(seams=2)), Exemplar.of(clip)).vote.tolerance == pytest.approx(
        0.4 * NOTICED, rel=1e-5
    )
    assert in_time(Settings(blocks=Blocks(seams=2)), Exemplar.of(clip)).blocks.seams == 2
