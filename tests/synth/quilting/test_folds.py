"""Mirrored copies: where they would fold the picture, and that they do not."""

import numpy as np
import pytest
import torch

from kwatra.pieces.boxes import Box
from kwatra.pieces.sheet import Patch
from synth.quilting import QuiltSettings, placement, quilt
from synth.quilting.folds import RADIUS, folded
from synth.quilting.synthesis import new_sheet, sources_of
from synth.quilting.variants import variants


def coordinates(high: int, wide: int) -> torch.Tensor:
    """An exemplar (2, high, wide) whose colors are its coordinates, y first."""
    return torch.stack(torch.meshgrid(torch.arange(high) * 1.0, torch.arange(wide) * 1.0, indexing="ij"))


@pytest.mark.parametrize("angle", [90.0, 180.0, 30.0])
def test_a_copy_knows_where_each_of_its_pixels_is_from(angle: float) -> None:
    exemplar = coordinates(24, 30)
    for copy in variants(exemplar, 1.0, (angle,), True):
        size = copy.image.shape[1:]
        center = (np.array(size) - 1) / 2
        at = coordinates(*size).numpy() - center[:, None, None]
        told = np.einsum("ij,jhw->ihw", copy.matrix, at) + np.array([11.5, 14.5])[:, None, None]
        inner = (slice(None), slice(3, -3), slice(3, -3))
        np.testing.assert_allclose(copy.image.numpy()[inner], told[inner], atol=0.05)


@pytest.mark.parametrize("shape", [(9, 12), (3, 9, 12)])
def test_folds_are_counted_as_by_hand(shape: tuple[int, ...]) -> None:
    exemplar = coordinates(9, 12)
    exemplar = exemplar if len(shape) == 2 else exemplar[:, None].repeat(1, 3, 1, 1)
    settings = QuiltSettings(rotate=(90.0,), mirror=True)
    sheet = new_sheet(sources_of(exemplar, settings), [2 * n for n in shape], settings)
    flat = (0,) * (len(shape) - 2)
    for number, shift in ((0, (*flat, 2, 1)), (1, (*flat, 5, 8)), (2, (*flat, -3, 10))):
        box = Box(shift, sheet.sources.shapes[number]).clipped(sheet.shape, sheet.periodic)
        sheet.lay(Patch(number, shift, box))
    number = 3
    span = Box((-1,) * len(shape), (3,) * len(flat) + (6, 5))
    found = folded(sheet, number, span, Box((-5,) * len(shape), tuple(2 * n + 9 for n in shape)))
    source = sheet.sources.images[number]
    here = sheet.sources.originals(sheet.places)
    opposite = np.isin(sheet.sources.coordinates(sheet.places)[0], (0, 1)) & sheet.filled
    # Its pixel that shows the same, wherever it lies, also past its border: told from its pixel (0, 0) on.
    slope_y, slope_x = (
        source[:, *flat, 1, 0] - source[:, *flat, 0, 0],
        source[:, *flat, 0, 1] - source[:, *flat, 0, 0],
    )
    turn = np.linalg.inv(np.stack([slope_y, slope_x], 1))
    for index in np.ndindex(*span.extent):
        translation = np.add(span.start, index)
        count = 0
        for pixel in zip(*np.nonzero(opposite), strict=True):
            same = turn @ (here[(slice(None), *pixel)] - source[:, *flat, 0, 0])
            gap = np.rint(np.array(pixel[-2:]) - same - translation[-2:])
            frame = len(flat) == 0 or sheet.sources.coordinates(sheet.places[pixel])[1][0] == pixel[0] - translation[0]
            count += bool(frame and (np.abs(gap) <= RADIUS).all())
        assert found[index] * (RADIUS + 1) == pytest.approx(count)


def folds_made(exemplar: torch.Tensor) -> float:
    """What part of the steps between a copy and a mirrored one shows the same pixel twice, within two pixels."""
    result = quilt(exemplar, (64, 64), QuiltSettings(mirror=True, refine=20))
    place = result.offset + torch.from_numpy(np.indices(result.patch.shape))
    row, column = place[0], torch.where(result.source == 1, exemplar.shape[2] - 1 - place[1], place[1])
    flips = result.source.diff(dim=1) != 0
    near = (row.diff(dim=1).abs() <= 2) & (column.diff(dim=1).abs() <= 2)
    return float(near[flips].float().mean())


def test_mirrored_copies_do_not_fold_the_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    rough = [torch.rand(1, 1, 40, 40, generator=torch.Generator().manual_seed(seed)) for seed in range(3)]
    smooth = [torch.nn.functional.avg_pool2d(noise, 9, 1)[0] for noise in rough]
    assert np.mean([folds_made(exemplar) for exemplar in smooth]) < 0.05
    monkeypatch.setattr(placement, "FOLD", 0.0)
    assert np.mean([folds_made(exemplar) for exemplar in smooth]) > 0.2
