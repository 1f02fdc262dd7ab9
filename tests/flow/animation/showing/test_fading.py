"""What is replaced in a video lives on below what replaces it, and fades; the first frame keeps a scene's places."""

from dataclasses import replace

import pytest
import torch
from torch import Tensor

import flow
from flow.animation.carrying.blur import blurred
from flow.animation.film.film import Film
from flow.animation.renewing.blocks import Blocks
from flow.animation.settings import VIDEO_PRESETS
from flow.animation.showing.fading import Fading, left_of, shaded, strengthened, strengths
from flow.warps import lookup, pixel_coordinates
from kwatra import Exemplar

SHAPE = (40, 48)
QUICK = replace(VIDEO_PRESETS["fast"], blocks=4, block=16, window=12, step=12, interpolation="bilinear")


def drops(frames: int = 8) -> Tensor:
    """A clip (1, frames, 48, 56) of drops, 1 on a ground of 0.5, elsewhere in every frame, and one black pixel."""
    draw = torch.rand(1, frames, 48, 56, generator=torch.Generator().manual_seed(0))
    clip = torch.where(draw < 0.05, 1.0, 0.5)
    clip[:, 0, 0, 0] = 0.0
    return clip


def test_a_drop_that_is_gone_leaves_no_dark_print() -> None:
    renewing = replace(QUICK, inertia=2.0, shades=0.0, feather=0)
    frames = list(flow.animate(drops(), flow.rotation(2.0), SHAPE, frames=10, renewing=renewing))
    assert sum(frame.energies[0]["renewed"] for frame in frames[1:]) > 0.3
    dark = torch.stack([(frame.image < 0.48).float().mean() for frame in frames])
    assert float(dark.max()) < 0.01


def test_what_lies_below_flows_lives_on_and_fades() -> None:
    film = Film.of(Exemplar.of(torch.rand(1, 6, 48, 56, generator=torch.Generator().manual_seed(1))))
    here = pixel_coordinates(SHAPE)
    look, inside = lookup(flow.uniform(1.0)(0, SHAPE)), torch.ones(SHAPE, dtype=torch.bool)
    image = torch.zeros(1, *SHAPE)
    nothing = Fading.nothing(here, image)
    above, below = torch.rand(2, 1, *SHAPE)
    assert torch.equal(nothing.shown(above, below, inside, 1), above)
    changed = here[0] < 20
    one = nothing.replaced(here, changed, 0.5)
    assert torch.equal(one.share, torch.where(changed, 0.5, 0.0))
    assert torch.allclose(one.mixed(above, below), torch.where(changed, (above + below) / 2, above))
    later = replace(one, shade=torch.ones_like(image)).onward(film, look, inside)
    assert torch.allclose(later.share[:, 1:], one.share[:, :-1])  # carried by one px to the right
    there = film.onward(here[:, 10:20, 9:19])
    assert torch.allclose(later.below[:, 10:20, 10:20], there, atol=1e-3)
    two = later.replaced(here, torch.zeros(SHAPE, dtype=torch.bool), 0.5)
    assert torch.allclose(two.share, later.share / 2)
    assert torch.equal(Fading.unpacked(two.packed).below, two.below)
    assert torch.equal(Fading.unpacked(two.packed).shade, two.shade)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_details_do_not_fade_with_what_is_mixed(share: float) -> None:
    above, below = 0.5 + 0.1 * torch.randn(2, 2, 96, 96, generator=torch.Generator().manual_seed(0))
    below[0] = 0.5 + 2 * (below[0] - 0.5)
    known = torch.ones(96, 96, dtype=torch.bool)
    known[:, :20] = False
    above[:, ~known] = below[:, ~known] = 9.0
    fading = Fading(torch.zeros(2, 96, 96), torch.where(known, share, 0.0), torch.zeros(2, 96, 96))
    seen = fading.shown(above, below, known, 1)[:, known]
    wanted = (1 - share) * above[0, known].var() + share * below[0, known].var()
    assert float(seen[0].var() / wanted) == pytest.approx(1, abs=0.08)
    plain = ((1 - share) * above + share * below)[:, known]
    assert float(seen[0].mean()) == pytest.approx(float(plain[0].mean()), abs=2e-3)
    assert torch.allclose(seen[1], plain[1])  # a map that goes along
    assert torch.allclose(fading.shown(above, above, known, 2), above, atol=1e-5)


def test_details_of_each_scale_get_back_what_mixing_takes_and_no_more() -> None:
    known = torch.ones(128, 128, dtype=torch.bool)
    fine, other = torch.randn(2, 1, 128, 128, generator=torch.Generator().manual_seed(0))
    coarse = 9 * blurred(torch.randn(1, 128, 128, generator=torch.Generator().manual_seed(1)), known, 4.0)
    one, two = coarse + fine, coarse + other  # they agree in what is coarse
    wanted = strengths(one, known)
    for mean, least in (((one + two) / 2, wanted / 2), (0.5 * coarse + (fine + other) / 2, wanted / 4)):
        assert float((strengths(mean, known) / wanted).mean((1, 2)).min()) < 0.7
        made = strengths(strengthened(mean, wanted, least, known), known)
        assert torch.allclose(made.mean((1, 2)), wanted.mean((1, 2)), rtol=0.15)
    assert torch.equal(strengthened(one, wanted / 2, 0 * wanted, known), one)
    assert torch.equal(strengthened(one / 3, wanted, wanted, known), one / 3)  # nothing was mixed


def test_what_is_replaced_fades_as_fast_as_the_clip_forgets() -> None:
    draw = torch.Generator().manual_seed(0)
    frames = [torch.randn(1, 40, 48, generator=draw)]
    for _ in range(60):  # a process that keeps 0.8 of itself from frame to frame
        frames.append(0.8 * frames[-1] + 0.6 * torch.randn(1, 40, 48, generator=draw))
    film = Film.of(Exemplar.of(torch.stack(frames, 1)))
    assert film.motion is not None
    film.motion.zero_()
    assert film.memory == pytest.approx(0.8, abs=0.05)
    assert left_of(film, 0.5) == pytest.approx(film.memory**2)
    assert film.backward.memory == film.memory
    assert left_of(film, 0.0) == 0.0
    still = Film.of(Exemplar.of(frames[0][:, None].expand(-1, 5, -1, -1)))
    assert still.memory == 0.0


def test_the_shade_is_what_is_brighter_on_the_whole() -> None:
    after, known = torch.rand(2, *SHAPE), torch.ones(SHAPE, dtype=torch.bool)
    assert torch.allclose(shaded(after + 0.3, after, known, 0.5), torch.tensor(0.15), atol=1e-5)
    fine = shaded(after + torch.randn(2, *SHAPE), after, known, 0.5)
    assert float(fine.abs().mean()) < 0.1
    known[:, :10] = False
    assert float(shaded(after + 0.3, after, known, 0.5)[:, :, :10].abs().max()) == 0
    assert float(shaded(after + 0.3, after, known, 0.0).abs().max()) == 0


def test_how_grainy_texture_is_is_told_and_heeded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flow.animation.film.film._GRAIN", 2.0)
    clips = []
    for seed in range(2):
        noise = torch.rand(1, 6, 48, 96, generator=torch.Generator().manual_seed(seed)) - 0.5
        noise[..., :48] = 0.0
        clips.append(Exemplar.of(0.5 + noise))
    film, other = (Film.of(clip) for clip in clips)
    grain = film.described.canvas[-1, :48]
    assert float(grain[:, 60:].mean()) > 3 * float(grain[:, :36].mean())
    assert float(film.described.canvas[-1].std()) == pytest.approx(float(film.strip.canvas.std()), rel=0.3)
    content, known = other.described.canvas[:, 20:36, 64:80][None], torch.ones(1, 1, 16, 16)
    free = torch.Generator().manual_seed(0)
    corner = Blocks(film, (16, 16)).nearest(content, known, lambda rows: torch.zeros(len(rows), 96), free)
    assert int(corner[0, 0]) >= 40  # of flat texture alone the mean fits better


def test_what_fades_is_passed_on_from_frame_to_frame() -> None:
    moving = {"exemplar": drops(), "field": flow.rotation(2.0), "shape": SHAPE, "renewing": QUICK}
    state = [frame.state for frame in flow.animate(**moving, frames=5)][-1]
    assert state.fading is not None
    told, untold = (next(flow.animate(**moving, after=each)) for each in (state, replace(state, fading=None)))
    assert not torch.equal(told.image, untold.image)


@pytest.mark.parametrize("seed", range(3))
def test_the_first_frame_of_a_scene_keeps_its_places(seed: int) -> None:
    noise = torch.rand(1, 6, 48, 56, generator=torch.Generator().manual_seed(0))
    clip = 0.3 * noise + 0.7 * torch.linspace(0, 1, 48).round().view(-1, 1)
    first = next(flow.animate(clip, flow.uniform(), SHAPE, frames=1, seed=seed, renewing=QUICK)).image
    assert float(first[:, :14].mean()) < 0.3
    assert float(first[:, -14:].mean()) > 0.7


def test_blurred_heeds_what_is_known_alone() -> None:
    image, known = torch.rand(1, 20, 20), torch.ones(20, 20, dtype=torch.bool)
    known[:, :6] = False
    other = torch.where(known, image, 5.0)
    assert torch.allclose(blurred(image, known, 2.0)[:, known], blurred(other, known, 2.0)[:, known], atol=1e-5)
    assert torch.allclose(
        blurred(torch.full((1, 9, 9), 0.7), torch.ones(9, 9, dtype=torch.bool), 2.0), torch.tensor(0.7)
    )
