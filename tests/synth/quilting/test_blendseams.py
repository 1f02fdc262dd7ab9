"""Blending across seams: what it leaves alone, what it softens and how far it reaches."""

import numpy as np
import pytest
import torch

from kwatra.pieces.boxes import Box
from kwatra.pieces.seams.cost import SeamCost
from kwatra.pieces.seams.mosaic import Mosaic
from kwatra.pieces.sheet import Patch, Sheet
from synth.quilting import QuiltSettings
from synth.quilting.blendseams import feather, spline
from synth.quilting.growth import fill
from synth.quilting.loops import unrolled
from synth.quilting.synthesis import new_placer, new_sheet, result_of, sources_of


def texture(*shape: int) -> torch.Tensor:
    """Noise, (C, *shape)."""
    return torch.rand(*shape, generator=torch.Generator().manual_seed(0))


def test_blending_leaves_patches_alone_and_softens_seams() -> None:
    settings = QuiltSettings(refine=0)
    exemplar = texture(1, 24, 24)
    sheet = new_sheet(sources_of(exemplar, settings), (40, 40), settings)
    fill(sheet, new_placer(sheet, settings, (6, 6)), None, lambda what, part: None)
    plain = sheet.sources.originals(sheet.places)
    for blended in (feather(sheet, 1.0), spline(sheet)):
        assert blended.shape == plain.shape
        assert not np.allclose(blended, plain, atol=1e-3)
        assert abs(blended.mean() - plain.mean()) < 0.02
    one = new_sheet(sheet.sources, (20, 20), settings)
    one.lay(Patch(0, (-2, -3), Box((0, 0), (20, 20))))
    for blended in (feather(one, 1.0), spline(one)):
        np.testing.assert_allclose(blended, one.sources.originals(one.places), atol=1e-5)


def test_a_patch_ends_gently_where_its_source_does() -> None:
    # A bright source of 8 rows on a dark one that runs on: splined, brightness must not jump where it ends.
    dark, bright = np.zeros((1, 40, 8), np.float32), np.ones((1, 8, 8), np.float32)
    sources = Mosaic([dark, bright])
    sheet = Sheet(sources, (40, 8), (False, False), SeamCost(sources))
    sheet.lay(Patch(0, (0, 0), Box((0, 0), (40, 8))))
    sheet.lay(Patch(1, (16, 0), Box((16, 0), (8, 8))), must=np.ones((8, 8), bool))
    level = spline(sheet)[0, :, 4]
    assert level[16:24].max() > 0.3
    assert np.abs(np.diff(level)).max() < 0.15


def test_feathering_spreads_a_seam_over_frames_more_than_over_pixels() -> None:
    # A small step in colour, and a third source that makes the range much larger.
    sources = Mosaic([np.full((1, 24, 24, 8), value, np.float32) for value in (0.0, 0.01, 1.0)])
    half = Box((0, 0, 0), (24, 24, 8))
    steps = []
    for axis in (0, 1):
        sheet = Sheet(sources, (24, 24, 8), (False,) * 3, SeamCost(sources))
        sheet.lay(Patch(0, (0, 0, 0), half))
        later = np.indices(half.extent)[axis] >= 12
        sheet.lay(Patch(1, (0, 0, 0), half), must=later, must_not=~later)
        level = feather(sheet, 1.0)[0].mean(tuple(other for other in range(3) if other != axis))
        steps.append(100 * np.diff(level).max())
    # The steepest step of a Gaussian's integral, over frames and over pixels.
    np.testing.assert_allclose(steps, [1 / (2 * np.sqrt(2 * np.pi)), 1 / np.sqrt(2 * np.pi)], rtol=0.05)


def test_splining_takes_what_moves_for_no_finer_than_what_rests() -> None:
    # Dark and bright side by side, all of it blinking: each frame is blended as wide as if nothing changed.
    dark, bright = np.zeros((1, 24, 8, 64), np.float32), np.ones((1, 24, 8, 64), np.float32)
    widths = []
    for light in (bright, bright * (np.arange(24) % 2).reshape(24, 1, 1)):
        sources = Mosaic([dark, light])
        sheet = Sheet(sources, (24, 8, 64), (False,) * 3, SeamCost(sources))
        sheet.lay(Patch(0, (0, 0, 0), Box((0, 0, 0), (24, 8, 64))))
        right = np.indices((24, 8, 64))[2] >= 32
        sheet.lay(Patch(1, (0, 0, 0), Box((0, 0, 0), (24, 8, 64))), must=right, must_not=~right)
        widths.append(np.diff(spline(sheet)[0, 13, 4]).max())
    assert widths[1] == pytest.approx(widths[0], abs=0.01)
    assert widths[0] < 0.1


def test_feathering_makes_no_ghosts_of_what_differs_much() -> None:
    dark, bright = np.zeros((1, 24, 8, 8), np.float32), np.ones((1, 24, 8, 8), np.float32)
    half = Box((0, 0, 0), (24, 8, 8))
    widths = []
    for step in (0.1, 1.0):
        # The range stays that of black to white.
        sources = Mosaic([dark, step * bright, bright])
        sheet = Sheet(sources, (24, 8, 8), (False,) * 3, SeamCost(sources))
        sheet.lay(Patch(0, (0, 0, 0), half))
        later = np.indices(half.extent)[0] >= 12
        sheet.lay(Patch(1, (0, 0, 0), half), must=later, must_not=~later)
        level = feather(sheet, 1.0)[0, :, 4, 4] / step
        widths.append(int(((level > 0.1) & (level < 0.9)).sum()))
    assert widths[0] >= 4
    assert widths[1] <= 2


def test_a_loop_is_feathered_across_its_join() -> None:
    settings = QuiltSettings(feather=1.0)
    sheet = new_sheet(sources_of(texture(1, 12, 9, 9), settings), (7, 9, 9), settings)
    sheet.lay(Patch(0, (0, 0, 0), Box((0, 0, 0), (7, 9, 9))))
    sheet.lay(Patch(0, (-4, 0, 0), Box((5, 0, 0), (2, 9, 9))), must=np.ones((2, 9, 9), bool))
    # Frame 0 is also the last; patches change after frames 4 and 6.
    sheet.places[0], sheet.label[0] = sheet.places[6], sheet.label[6]
    near, far = (feather(unrolled(sheet, 1, margin), 1.0)[:, margin : margin + 6] for margin in (6, 20))
    np.testing.assert_allclose(near, far, atol=1e-6)
    looped = result_of(sheet, settings, [sheet.total], "", first=1).image
    np.testing.assert_allclose(looped, far, atol=1e-6)
    plain = sheet.sources.originals(sheet.places)[:, 1:]
    assert not np.allclose(looped[:, 0], plain[:, 0], atol=1e-3)
    assert not np.allclose(looped[:, 5], plain[:, 5], atol=1e-3)
