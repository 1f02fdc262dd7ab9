"""How strongly what belongs somewhere in the frame stays there."""

import pytest
import torch

from kwatra import Exemplar, InputError
from kwatra.terms.stay import STAYING
from synth import synthesize
from synth.texture.staying import ENLARGED, LARGEST, staying


def scene() -> torch.Tensor:
    """Dark above, bright below, (1, 4, 16, 24)."""
    noise = 0.1 * torch.rand(1, 4, 16, 24, generator=torch.Generator().manual_seed(0))
    noise[:, :, 8:] += 0.9
    return noise


@pytest.mark.parametrize(
    ("shape", "larger"), [((9, 16, 24), 1), ((4, 8, 12), 1), ((4, 24, 24), 1.5), ((4, 32, 48), LARGEST)]
)
def test_a_scene_stays_the_more_the_larger_it_is_made(shape, larger):
    (term,) = staying(None, Exemplar.of(scene()), shape, tile=False)
    assert term.weight == pytest.approx(STAYING * larger ** ENLARGED[0])


def test_what_lasts_stays_less():
    lasts = scene()[:, :1] + 0.01 * torch.arange(8.0).view(1, -1, 1, 1)
    (term,) = staying(None, Exemplar.of(lasts), (8, 24, 24), tile=False)
    assert term.weight == pytest.approx(STAYING * 1.5 ** ENLARGED[1])


def test_of_several_clips_the_largest_says_what_is_larger():
    clips = [scene(), scene()[..., :8, :12]]
    (term,) = staying(None, Exemplar.of(clips), (4, 16, 24), tile=False)
    assert term.weight == STAYING


def test_a_weight_that_is_given_is_meant():
    (term,) = staying(0.2, Exemplar.of(scene()), (4, 32, 48), tile=False)
    assert term.weight == 0.2
    assert staying(0.0, Exemplar.of(scene()), (4, 32, 48), tile=False) == []


def test_what_has_no_places_does_not_stay():
    assert staying(None, Exemplar.of(scene()), (4, 16, 24), tile=True) == []
    assert staying(None, Exemplar.of(torch.rand(1, 16, 24)), (32, 48), tile=False) == []
    with pytest.raises(InputError, match="what tiles has no places"):
        staying(0.2, Exemplar.of(scene()), (4, 16, 24), tile=True)


@pytest.mark.parametrize("preset", ["fast", "default"])
def test_a_still_stays_if_it_is_asked_to(preset):
    still = torch.rand(1, 40, 40, generator=torch.Generator().manual_seed(0))
    place = torch.stack(torch.meshgrid(torch.arange(40), torch.arange(40), indexing="ij"))
    made = synthesize(still, (40, 40), stay=5.0, preset=preset).result
    assert torch.equal(made.where, place)
    assert "stay" in made.energies[-1]
    assert not torch.equal(synthesize(still, (40, 40), preset=preset).result.where, place)


@pytest.mark.parametrize("frames", [2, 3])
def test_a_loop_of_few_frames_stays_too(frames):
    """Its blocks are a frame long, so that some begin with a clip's last one."""
    made = synthesize(scene(), (frames, 16, 24), preset="fast", stay=1.0, loop=True).image
    assert made[..., 8:, :].mean() > 0.8
    assert made[..., :8, :].mean() < 0.2
