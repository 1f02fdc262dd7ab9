"""The steerable pyramid, judged by plenoptic's."""

import numpy as np
import pytest
import torch
from textures import noise

from synth.metamorphosis.patches.pyramid import Pyramid

SIZES = pytest.mark.parametrize(("shape", "octaves"), [((1, 16, 16), 1), ((3, 64, 48), 3), ((2, 37, 51), 2)])


@SIZES
@pytest.mark.parametrize("wrap", [False, True])
def test_bands_and_what_is_made_of_changed_ones_are_plenoptic_s(
    shape: tuple[int, ...], octaves: int, wrap: bool
) -> None:
    from plenoptic.process import SteerablePyramidFreq

    image = noise(*shape)
    own = Pyramid.of(image, wrap, octaves, None)
    frame = (own.finest.shape[1], own.finest.shape[2])
    judge = SteerablePyramidFreq(frame, height=octaves, order=3, is_complex=True, tight_frame=True)
    around = [(0, 0), *((16, long - 16 - size) for long, size in zip(frame, shape[1:], strict=True))]
    continued = torch.from_numpy(np.pad(image.numpy(), around, "wrap" if wrap else "symmetric"))
    theirs = judge(continued[None])
    torch.testing.assert_close(own.finest, theirs["residual_highpass"][0], atol=1e-5, rtol=0)
    for number, band in enumerate(own.bands):
        torch.testing.assert_close(band, theirs[number][0], atol=1e-5, rtol=0)
        own.bands[number] = band * band.abs()
        theirs[number] = own.bands[number][None]
    made = judge.recon_pyr(theirs)[0, :, 16 : 16 + shape[1], 16 : 16 + shape[2]]
    torch.testing.assert_close(own.image(), made, atol=1e-5, rtol=0)


@SIZES
def test_an_image_comes_back(shape: tuple[int, ...], octaves: int) -> None:
    image = noise(*shape)
    torch.testing.assert_close(Pyramid.of(image, False, octaves, None).image(), image, atol=1e-6, rtol=0)
