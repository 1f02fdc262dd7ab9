"""Edges and blobs, where it is known how strong and how wide they are."""

import math

import torch

from synth.metamorphosis.features import blobs, edges


def test_an_edge_is_seen_with_a_blur_of_a_pixel() -> None:
    image = torch.zeros(3, 24, 40)
    image[..., 20:] = 0.8
    found = edges(image)
    assert found.shape == (1, 24, 40)
    for away in range(4):  # the slope of a step of .8 blurred by s = 1 px, (away + 1 / 2) px from it
        slope = 0.8 * math.exp(-((away + 0.5) ** 2) / 2) / math.sqrt(2 * math.pi)
        torch.testing.assert_close(found[0, :, [19 - away, 20 + away]], torch.full((24, 2), slope), atol=0.01, rtol=0)


def test_a_blob_is_what_differs_from_its_surroundings_whether_lighter_or_darker() -> None:
    image = torch.zeros(1, 48, 48)
    image[:, 24, 24] = 1.0
    found = blobs(image)
    # of a point blurred by s px the middle is 1 / (2 pi s^2)
    middle = (1 / 1.5**2 - 1 / 4.5**2) / (2 * math.pi)
    assert abs(float(found[0, 24, 24]) - middle) < 0.05 * middle
    torch.testing.assert_close(blobs(1 - image), found, atol=1e-6, rtol=0)
