from dataclasses import replace

import numpy as np
import pytest
import torch
from compared import shown_near

from kwatra import Exemplar
from kwatra.pieces import BlockStart, Box, Mosaic, Patch, SeamCost, Sheet
from kwatra.pieces.choosing import candidates
from kwatra.pieces.choosing.corners import Corners
from kwatra.pieces.choosing.twins import twin_places, twins


def noise(height=40, width=32, seed=0):
    return torch.rand(3, height, width, generator=torch.Generator().manual_seed(seed))


def flat(exemplar):
    return torch.arange(exemplar.owner.numel()).view(exemplar.owner.shape)


def test_what_has_no_variants_has_no_twins():
    assert twins(Exemplar.of([noise(), noise(30, 20, 1)])) == []


def test_frames_of_a_video_are_no_twins():
    pages = Exemplar.of([noise(), noise(seed=1)])
    frames = torch.cat([torch.zeros_like(pages.origin[:1]), pages.origin])  # of one clip, each with its number
    assert twins(replace(pages, origin=frames)) == []


@pytest.mark.parametrize("factor", [1, 2])
def test_a_mirrored_pixel_shows_the_same(factor):
    exemplar = Exemplar.of([noise(), noise(24, 16, 1)], mirror=True).coarser((factor, factor))
    (twin,) = twins(exemplar)
    owned = exemplar.owner >= 0
    assert (twin[~owned] == -1).all()
    assert torch.allclose(exemplar.canvas.flatten(1)[:, twin[owned]], exemplar.canvas[:, owned])
    assert (exemplar.owner.flatten()[twin[owned]] != exemplar.owner[owned]).all()
    assert torch.equal(twin.flatten()[twin[owned]], flat(exemplar)[owned])  # and that one's is the first


def test_turned_and_resized_pixels_come_from_about_there():
    exemplar = Exemplar.of(noise(), rotate=(30.0, 90.0), scale=(0.8,))
    found = twins(exemplar)
    assert len(found) == 3
    inside = exemplar.owner == 0
    for twin in found:
        there = twin[inside]
        origin = exemplar.origin[1:].flatten(1)[:, there]
        away = (origin - exemplar.origin[1:, inside]).abs().amax(0)
        assert (away <= 1).float().mean() > 0.9  # but in corners that are not there
        assert len(exemplar.owner.flatten()[there].unique()) == 1
    assert len({int(exemplar.owner.flatten()[twin[inside][0]]) for twin in found}) == 3


def test_places_are_those_of_the_mosaic():
    exemplar = Exemplar.of(noise(), mirror=True)
    mosaic = Mosaic([exemplar.canvas.numpy()])
    (table,) = twin_places(exemplar, mosaic)
    (twin,) = twins(exemplar)
    for row, column in ((3, 5), (39, 31), (50, 0)):
        place = mosaic.places_of([np.array(row), np.array(column)])
        wanted = divmod(int(twin[row, column]), exemplar.shape[1])
        assert table[place] == mosaic.places_of([np.array(at) for at in wanted])
    assert (table[mosaic.places_of([np.array([42]), np.array([3])])] == -1).all()  # between the two


def test_twins_of_what_is_shown_nearby_count_as_it_does():
    exemplar = Exemplar.of(noise(12, 10), mirror=True)
    mosaic = Mosaic([exemplar.canvas.numpy()])
    sheet = Sheet(mosaic, (9, 9), (False, False), SeamCost(mosaic))
    sheet.lay(Patch(0, (0, 0), Box((0, 0), (6, 9))), must=np.ones((6, 9), bool))
    corners, tables = Corners.fitting(exemplar, (3, 3), (1, 1)), twin_places(exemplar, mosaic)
    near = shown_near(sheet, [Box((5, 2), (3, 3))], corners, tables)[0].reshape(corners.valid.shape)
    alone = shown_near(sheet, [Box((5, 2), (3, 3))], corners, tables[:0])[0].reshape(corners.valid.shape)
    first = int((exemplar.owner == 1).nonzero()[0, 0])
    np.testing.assert_allclose(near[first : first + 10], alone[:10, ::-1])
    np.testing.assert_allclose(near[:10], alone[:10])
    assert alone[:10].any()


def folds(monkeypatch, fold):
    """How many pairs of neighbors show one place, or two side by side, of an image and of its mirror image."""
    monkeypatch.setattr(candidates, "FOLD", fold)
    exemplar, count = Exemplar.of(noise(64, 64), mirror=True), 0
    for seed in range(3):
        generator = torch.Generator().manual_seed(seed)
        where = BlockStart(exemplar, (160, 160), (32, 32), (1, 1), generator, usage=0.5, seams=6).run()
        owner, origin = exemplar.owner[tuple(where)], exemplar.origin[(slice(1, None), *where)]
        for axis in range(2):
            apart = origin.diff(dim=axis + 1).abs().amax(0)
            count += int(((owner.diff(dim=axis) != 0) & (apart <= 1)).sum())
    return count


def test_few_folds_are_laid(monkeypatch):
    assert folds(monkeypatch, candidates.FOLD) < 0.5 * folds(monkeypatch, 0.0)
