"""What is done to the colors of videos with alpha leaves alpha as it is."""

import torch

import synth
from kwatra import Exemplar
from synth.texture import work
from synth.texture.transparency import as_far_as_seen


def cutout(frames=4, side=24):
    """Colored noise that is there in the left half, fades in the next quarter and is not there behind it."""
    alpha = (3 - 4 * torch.arange(side) / side).clamp(0, 1).expand(1, frames, side, side)
    colors = 0.2 + 0.6 * torch.rand(3, frames, side, side, generator=torch.Generator().manual_seed(0))
    return torch.cat([colors * alpha, alpha])


def test_colors_change_as_far_as_they_are_seen_and_alpha_does_not():
    z = cutout()
    brighter = z + 0.1
    made = as_far_as_seen(z, brighter, Exemplar.of(z))
    alpha = z[-1:]
    assert torch.equal(made[-1:], alpha)
    assert torch.allclose(made[:-1], z[:-1] + 0.1 * alpha, atol=1e-6)
    glaring = as_far_as_seen(z, z + 1, Exemplar.of(z))
    assert torch.equal(glaring[:-1], alpha.expand(3, -1, -1, -1))  # what is more than alpha is no color


def test_what_is_opaque_or_has_no_alpha_is_as_it_came_to_be():
    z = cutout()
    opaque = torch.cat([z[:3], torch.ones(1, *z.shape[1:])])
    brighter = torch.cat([opaque[:3] + 0.1, opaque[3:]])
    assert torch.equal(as_far_as_seen(opaque, brighter, Exemplar.of(opaque)), brighter)
    deep = torch.cat([opaque[:3], z[:1]])
    for few in (z[:3], deep, torch.cat([z, z[:1]]), z[:2]):
        assert as_far_as_seen(few, few + 0.1, Exemplar.of(few)).equal(few + 0.1)


def test_a_clip_with_alpha_keeps_it_under_strong_details_and_even_light(monkeypatch):
    z = cutout(8, 48)
    with monkeypatch.context() as patched:
        for name in ("steepened", "evened"):
            patched.setattr(work, name, lambda video, *_: video)
        plain = synth.synthesize(z, (10, 56, 56), preset="fast").image
    made = synth.synthesize(z, (10, 56, 56), preset="fast").image
    assert torch.equal(made[-1], plain[-1])
    assert bool((made[:-1] <= made[-1]).all())
    assert not torch.equal(made[:-1], plain[:-1])
