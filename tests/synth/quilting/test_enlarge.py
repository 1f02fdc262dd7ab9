"""Larger frames, and where the borders of what is copied may lie."""

import dataclasses
import itertools

import numpy as np
import pytest
import torch

from kwatra.pieces.boxes import Box
from kwatra.pieces.sheet import Patch
from synth.quilting import QuiltSettings, default_settings, quilt_video
from synth.quilting.borders import admitted, homely, margins, trimmed
from synth.quilting.enlarge import SPARE, enlarged, stations
from synth.quilting.growth import fill
from synth.quilting.synthesis import new_placer, new_sheet, sources_of
from synth.quilting.video import DRIFT


def quiet(what: str, part: float) -> None:
    """No report."""


def clip(*shape: int) -> torch.Tensor:
    """Noise, (1, *shape)."""
    return torch.rand(1, *shape, generator=torch.Generator().manual_seed(1))


@pytest.mark.parametrize("inside", [False, True])
@pytest.mark.parametrize("periodic", [(False, False), (True, False)])
@pytest.mark.parametrize("source", [(10, 9), (30, 9)])
def test_admitted_offsets_are_those_whose_trimmed_source_covers_the_region(inside, periodic, source) -> None:
    shape, margin, region = (20, 24), (2, 1), Box((6, 0), (4, 3))
    span = Box((-12, -6), (22, 16))
    found = admitted(span, source, region, shape, periodic, margin, inside)
    for at in np.ndindex(*span.extent):
        shift = tuple(s + i for s, i in zip(span.start, at, strict=True))
        box = trimmed(Box(shift, source), shape, periodic, margin)
        covers = all(
            low <= a and b <= high
            for low, high, a, b in zip(box.start, box.stop, region.start, region.stop, strict=True)
        )
        nested = all(
            wraps or (t >= 0 and t + e <= n) or (t <= 0 and t + e >= n)
            for t, e, n, wraps in zip(shift, source, shape, periodic, strict=True)
        )
        assert found[at] == (covers and (nested or not inside))


@pytest.mark.parametrize("inside", [False, True])
def test_margins_never_leave_a_region_that_nothing_covers(inside) -> None:
    source, extent, shape = (12,), (5,), (31,)
    margin = margins(source, extent, (50,))
    assert margin == (1,)
    for first in range(shape[0] - extent[0] + 1):
        span = Box((first + extent[0] - source[0],), (source[0] - extent[0] + 1,))
        assert admitted(span, source, Box((first,), extent), shape, (False,), margin, inside).any()


def test_offsets_near_home_are_short_or_the_shortest_there_are() -> None:
    found = homely(Box((-5, 3), (9, 4)), (2, 1))
    assert np.argwhere(found).tolist() == [[3, 0], [4, 0], [5, 0], [6, 0], [7, 0]]


def test_what_is_moved_in_a_scene_stays_near_its_place() -> None:
    y, x = torch.meshgrid(torch.linspace(0, 1, 24), torch.linspace(0, 1, 32), indexing="ij")
    scene = torch.stack([y, x])[:, None] + 0.02 * clip(8, 24, 32)  # noise would flow anywhere, but light falls so
    settings = dataclasses.replace(default_settings("spacetime"), placement="random")
    result = quilt_video(scene, 20, mode="spacetime", settings=settings)
    across = result.offset[1:].abs().amax((1, 2, 3))
    assert 0 < int(across[0]) <= 24 // DRIFT
    assert 0 < int(across[1]) <= 32 // DRIFT


def test_splined_patches_end_before_their_sources_do() -> None:
    settings = QuiltSettings(spline=True, placement="random")
    sheet = new_sheet(sources_of(clip(48, 48), settings), (90, 90), settings)
    fill(sheet, new_placer(sheet, settings, (12, 12)), None, quiet)
    for patch, axis in itertools.product(sheet.patches, range(2)):
        before = patch.box.start[axis] - patch.shift[axis]
        behind = patch.shift[axis] + 48 - patch.box.stop[axis]
        assert before >= 9 or patch.shift[axis] <= 0
        assert behind >= 9 or patch.shift[axis] + 48 >= 90


@pytest.mark.parametrize(("source", "size"), [(40, 50), (40, 41), (40, 160), (33, 95), (40, 40), (40, 30), (9, 31)])
def test_copies_at_the_stations_cover_a_frame_and_overlap(source, size) -> None:
    regions = stations((source,), (size,))
    assert regions[0].start == (0,)
    assert regions[-1].stop == (size,)
    margin = margins((source,), regions[0].extent, (100,))
    ends = []
    for region in regions:
        span = Box((region.stop[0] - source,), (source - region.extent[0] + 1,)) if source < size else None
        if span is None:
            continue
        fits = np.flatnonzero(admitted(span, (source,), region, (size,), (False,), margin, True))
        assert len(fits)
        middle = span.start[0] + int(fits[len(fits) // 2])
        box = trimmed(Box((middle,), (source,)), (size,), (False,), margin)
        ends.append((box.start[0], box.stop[0]))
    for (_, last), (first, _) in itertools.pairwise(ends):
        assert first < last


def test_larger_frames_keep_the_clips_borders_and_its_motion_out_of_step() -> None:
    # Every pixel of the clip tells its row and its column; time it tells by nothing.
    y, x = torch.meshgrid(torch.arange(48.0), torch.arange(48.0), indexing="ij")
    still = torch.stack([y, x])[:, None].expand(2, 24, -1, -1).contiguous()
    settings = default_settings("spacetime")
    larger = enlarged(still, (60, 60), settings, quiet)
    assert larger.image.shape == (2, 24 - 24 // SPARE, 60, 60)
    offset = larger.offset.numpy()
    assert (offset[1, :, 0] == 0).all()
    assert (offset[1, :, -1] == -12).all()
    assert (offset[2, ..., 0] == 0).all()
    assert (offset[2, ..., -1] == -12).all()
    corners = [int(offset[0, 0, v, u]) for v in (0, -1) for u in (0, -1)]
    assert len(set(corners)) == 4


def test_longer_and_larger_is_twice_as_long_as_the_clip() -> None:
    result = quilt_video(clip(10, 16, 16), None, (20, 20), mode="spacetime", settings=QuiltSettings(refine=1))
    assert result.image.shape == (1, 20, 20, 20)


def test_a_patch_is_scaled_with_its_box() -> None:
    patch = Patch(0, (-1, 3, 2), Box((0, 3, 2), (5, 8, 10)))
    assert patch.scaled((2, 4, 4), (10, 44, 45)) == Patch(0, (-2, 12, 8), Box((0, 12, 8), (10, 32, 37)))


def test_what_is_moved_in_space_and_time_grows_from_the_clip_in_place() -> None:
    settings = dataclasses.replace(default_settings("spacetime"), refine=0)
    result = quilt_video(clip(10, 16, 16), mode="spacetime", settings=settings)
    there = np.stack(np.broadcast_arrays(-5, 0, 0)).reshape(3, 1, 1)
    assert (result.offset.numpy()[:, 10] == there).all(0).mean() > 0.9
