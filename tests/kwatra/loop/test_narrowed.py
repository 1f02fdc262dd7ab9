"""Blocks of textures that run along an axis, and those of scenes that are made higher."""

import math

import numpy as np
import pytest
import torch
from scipy import ndimage

from kwatra import Exemplar, Settings, Stay, begin, optimize
from kwatra.loop.laying import narrowed
from kwatra.pieces import BlockStart


@pytest.mark.parametrize(
    ("anisotropy", "made", "along"),
    [
        (2.0, (48, 48), None),
        (0.5, (48, 48), None),
        (4.0, (48, 32), 0),
        (0.25, (32, 48), 1),
        (math.inf, (48, 8), 0),
        (0.0, (8, 48), 1),
    ],
)
def test_blocks_of_what_runs_along_an_axis_are_narrow(anisotropy, made, along):
    assert narrowed((48, 48), anisotropy, (4, 4)) == (made, along)
    assert narrowed((6, 6), anisotropy, (1, 1)) == ((6, 6), along)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("wrap", [False, True])
def test_the_ends_of_blocks_make_no_line_across_what_runs_along_an_axis(axis, wrap):
    rough = ndimage.gaussian_filter(np.random.default_rng(2).normal(size=(96, 96)), (24, 0.8))
    image = torch.from_numpy(0.5 + 0.15 * (rough - rough.mean()) / rough.std()).float()[None]
    image, shape = (image, (160, 96)) if axis == 0 else (image.mT, (96, 160))
    made = optimize(Exemplar.of(image), shape, settings=Settings(wrap=wrap)).image

    def steepest(picture):
        return picture.diff(dim=axis + 1).abs().mean(dim=(0, 2 - axis)).max()

    assert steepest(made) < 4 * steepest(image)  # 1.6 to 2.0 times as steep; 6.2 to 12 with square blocks


@pytest.mark.parametrize(("height", "terms", "out"), [(36, Stay(0.3), False), (37, Stay(0.3), True), (37, (), False)])
def test_of_a_scene_in_much_higher_frames_blocks_beside_each_other_are_out_of_step(height, terms, out):
    clip = Exemplar.of(torch.rand(1, 4, 24, 24, generator=torch.Generator().manual_seed(0)))
    blocks = begin(clip, (4, height, 36), terms=terms).blocks
    assert isinstance(blocks, BlockStart)
    rows = dict[int, set[int]]()
    for _, row, column in blocks.layer.spread.corners:
        rows.setdefault(column, set()).add(row)
    assert len(rows) > 1
    assert out == (len(set(map(frozenset, rows.values()))) > 1)
