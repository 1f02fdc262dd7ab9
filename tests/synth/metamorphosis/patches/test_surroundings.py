"""A texture in the middle of more of it."""

import torch

from synth.metamorphosis.patches.surroundings import surrounded


def spots() -> torch.Tensor:
    """Blue discs on sand, 40x48."""
    y, x = torch.meshgrid(torch.arange(40) % 10 - 5, torch.arange(48) % 12 - 6, indexing="ij")
    inside = (y.square() + x.square() < 10).float()
    sand, blue = (torch.tensor(color).view(3, 1, 1) for color in ((0.9, 0.8, 0.6), (0.1, 0.2, 0.7)))
    return sand + (blue - sand) * inside


def test_the_image_is_in_the_middle_and_features_are_where_their_colors_are() -> None:
    image = spots()
    larger, features = surrounded(image, image[0] < 0.5, 1.5, "fast", 0)
    assert larger.shape == (3, 60, 72)
    assert torch.equal(larger[:, 10:-10, 12:-12], image)
    assert torch.equal(features[10:-10, 12:-12], image[0] < 0.5)
    assert float((features == (larger[0] < 0.5)).float().mean()) > 0.95
    assert 0.6 < float((larger[0] < 0.5).float().mean() / (image[0] < 0.5).float().mean()) < 1.6


def test_what_is_to_be_no_larger_stays_as_it_is() -> None:
    image = spots()
    same, features = surrounded(image, image[0] < 0.5, 1.0, "fast", 0)
    assert same is image
    assert torch.equal(features, image[0] < 0.5)
