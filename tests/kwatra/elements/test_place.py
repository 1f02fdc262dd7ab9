"""Whether a video's statistics depend on the place."""

import torch
from textures import noise

from kwatra import Exemplar, place_dependence


def test_noise_is_alike_everywhere():
    assert abs(place_dependence(Exemplar.of(noise(3, 24, 32, 40, seed=5)))) < 0.3


def test_a_scene_has_its_places():
    video = noise(3, 24, 32, 40, seed=5)
    video[:, :, 20:] *= 0.5
    assert place_dependence(Exemplar.of(video)) > 0.9


def test_texture_that_passes_by_is_alike_everywhere():
    wide = torch.nn.functional.avg_pool2d(noise(1, 48, 400, seed=5), 9, 1)
    video = torch.stack([wide[:, :, 8 * t : 8 * t + 40] for t in range(40)], 1)
    assert place_dependence(Exemplar.of(video)) < 0.5


def test_images_and_single_frames_tell_nothing():
    assert place_dependence(Exemplar.of(noise(3, 24, 24, seed=5))) == 0
    assert place_dependence(Exemplar.of(noise(3, 1, 24, 24, seed=5))) == 0
