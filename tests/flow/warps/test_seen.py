"""The motion seen between images is the motion they were given; distances between fields are what they are."""

import math

import pytest
import torch
from skimage import data
from torch import Tensor

import flow
from kwatra import InputError


def gravel(size: int = 160) -> Tensor:
    return torch.from_numpy(data.gravel()[:size, :size] / 255).float()[None].expand(3, -1, -1)


@pytest.mark.parametrize("name", ["uniform:30", "rotation", "sink", "source"])
def test_a_known_motion_is_seen(name: str) -> None:
    forward = flow.named(name)(0.0, (160, 160))
    moved = flow.warp(gravel(), flow.lookup(forward).coordinates)
    assert flow.end_point_error(flow.seen(gravel(), moved), forward) < 0.1
    assert flow.end_point_error(flow.seen(moved, gravel()), forward) > 1  # the way back is not the way there


def test_no_motion_is_seen_between_equal_images_and_threads_do_not_matter() -> None:
    import cv2

    assert float(flow.seen(gravel(), gravel()).abs().max()) < 1e-3
    moved = gravel().roll(2, 2)
    threads, seen = cv2.getNumThreads(), []
    try:
        for count in (1, 4):
            cv2.setNumThreads(count)
            seen.append(flow.seen(gravel(), moved))
    finally:
        cv2.setNumThreads(threads)
    assert torch.equal(*seen)


def test_the_end_point_error_counts_what_is_known_off_the_border() -> None:
    truth, other = torch.zeros(2, 20, 24), torch.zeros(2, 20, 24)
    other[0], other[1] = 3, 4
    assert math.isclose(flow.end_point_error(other, truth, border=2), 5.0)
    other[:, :4] = other[:, -4:] = other[:, :, :4] = other[:, :, -4:] = 9
    assert math.isclose(flow.end_point_error(other, truth, border=4), 5.0)
    known = torch.zeros(20, 24, dtype=torch.bool)
    known[10, 10] = known[10, 11] = True
    other[:, 10, 10] = 0
    assert math.isclose(flow.end_point_error(other, truth, known, border=4), 2.5)
    with pytest.raises(InputError, match="no vector is known farther than 16 px from the border"):
        flow.end_point_error(other, truth, known)


def test_images_that_cannot_be_compared_are_refused() -> None:
    with pytest.raises(InputError, match=r"give two \(C, H, W\) of one size, at least 16x16"):
        flow.seen(gravel(), gravel(100))
    with pytest.raises(InputError, match=r"at least 16x16"):
        flow.seen(gravel(8), gravel(8))
    with pytest.raises(InputError, match="a flow is 24x20 but the frame 30x30"):
        flow.end_point_error(torch.zeros(2, 20, 24), torch.zeros(2, 30, 30))
