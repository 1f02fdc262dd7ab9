"""Algorithm 3 as published: its flow term is equation 27, and its frames follow the flow."""

import pytest
import torch
from torch import Tensor

import flow
from flow.animation.term import lasting
from flow.animation.thesis import with_variants
from kwatra import Exemplar, InputError, optimize
from kwatra.terms.algebra import parts_of

SHAPE = (40, 48)


def noise(channels: int = 1, shape: tuple[int, int] = SHAPE) -> Tensor:
    return torch.rand(channels, *shape, generator=torch.Generator().manual_seed(0))


def by_definition(before: Tensor) -> tuple[Tensor, Tensor]:
    """x+, a frame moved right by 3 px, and K from its gradients, 0 where nothing is known: equation 27's, by hand."""
    warped = before.clone()
    warped[..., 3:] = before[..., :-3]
    warped[..., :3] = warped[..., 3:4]  # not known: continued, but without weight
    steps = torch.zeros(SHAPE)
    steps[:, :-1] += warped.diff(dim=2).abs().mean(0)
    steps[:-1] += warped.diff(dim=1).abs().mean(0)
    gradient = 0.5 + 0.5 * steps / steps.mean()
    gradient[:, :3] = 0
    return warped, gradient


def test_the_flow_term_is_equation_27() -> None:
    """lambda (x - x+)^T K (x - x+) with x+ the warped frame and K from its gradients, a mean over its values."""
    before, x, weight = noise(3), 1 - noise(3), 0.7
    term = flow.flow_term(before, flow.lookup(flow.uniform(3.0)(0, SHAPE)), weight)
    warped, gradient = by_definition(before)
    expected = weight * float((gradient * (x - warped).square()).mean())
    assert term.name == "flow"
    assert term.energy(x) == pytest.approx(expected, rel=1e-4)


def test_the_flow_terms_quadratic_has_equation_27s_gradient() -> None:
    before, x, weight = noise(2), (1 - noise(2)).requires_grad_(), 0.5
    term = flow.flow_term(before, flow.lookup(flow.uniform(3.0)(0, SHAPE)), weight)
    warped, gradient = by_definition(before)
    (weight * gradient * (x - warped).square()).sum().backward()
    quadratic = term.quadratic(torch.zeros_like(before))
    assert torch.allclose(2 * quadratic.times(x.detach() - quadratic.target), x.grad, atol=1e-5)
    assert torch.allclose(quadratic.diagonal.expand_as(x), quadratic.times(torch.ones_like(x)), atol=1e-6)
    assert len(parts_of(term)) == 1
    assert term.energy(quadratic.target) == 0


def test_what_agrees_lasts_and_what_is_unlike_is_never_seen_through() -> None:
    off = torch.linspace(0, 3, 600).square()
    share = lasting(off, 1.5)
    assert torch.allclose(share[0], torch.tensor(0.6))  # 1.5 / 2.5
    assert bool((share.diff() <= 0).all())
    assert float((share * off.sqrt()).max()) < 0.11  # deviations that a pixel is off its copies by
    assert float((share * off.sqrt())[off > 1].max()) < 1e-4
    assert float(lasting(off, 0.0).max()) == 0


def test_the_flow_term_counts_edges_more() -> None:
    step = torch.zeros(1, *SHAPE)
    step[..., 24:] = 1
    weights = flow.flow_term(step, flow.lookup(torch.zeros(2, *SHAPE)), 2.0).weight[0]
    assert float(weights[20, 23]) > 10 * float(weights[20, 10])
    assert float(weights.mean()) == pytest.approx(2.0)


def test_one_color_stays() -> None:
    plain = torch.full((3, 32, 32), 0.3)
    for frame in flow.published(Exemplar.of(plain), flow.rotation(2.0), SHAPE, 3):
        assert float((frame.image - 0.3).abs().max()) < 1e-4


def test_frames_follow_the_flow_and_start_as_the_animation_does() -> None:
    exemplar, field = Exemplar.of(noise(1, (48, 48))), flow.uniform(2.0)
    first, second = flow.published(exemplar, field, SHAPE, 2)
    moved = first.image[..., 10:-12]
    assert float((second.image[..., 12:-10] - moved).abs().mean()) < 0.5 * float(
        (second.image[..., 10:-12] - moved).abs().mean()
    )
    assert {row["level"] for row in second.energies} == {0, 1}
    assert all("flow" in row for row in second.energies)
    animated = next(flow.animate(exemplar, field, SHAPE, turn=False))
    same = (first.where == animated.where).all(0).float().mean()  # all but crumbs, which the animation takes away
    assert float(same) > 0.98
    assert len(list(flow.published(exemplar, field, SHAPE, 1))) == 1


def drifting() -> Tensor:
    """A clip (1, 6, 36, 36) of soft noise that moves right by 1 px a frame."""
    wide = torch.nn.functional.avg_pool2d(noise(1, (36, 48))[None], 5, 1, 2)[0]
    wide = (wide - wide.amin()) / (wide.amax() - wide.amin())
    return torch.stack([wide[..., 6 - t : 42 - t] for t in range(6)], 1)


def test_a_video_is_made_as_a_volume_of_equation_29() -> None:
    field, clip, mask = flow.uniform(1.0), drifting(), torch.ones(24, 28, dtype=torch.bool)
    frames = list(flow.published(clip, field, (24, 28), 6, seed=1))
    made = torch.stack([frame.image for frame in frames], 1)
    flows = field(0, (24, 28))[None].expand(5, -1, -1, -1)
    term = flow.VolumeFlow(flows, 0.3)
    again = optimize(Exemplar.of(clip), (6, 24, 28), terms=term, seed=1)
    assert torch.equal(made, again.image)
    assert {"texture", "flow"} <= set(frames[0].energies[-1])
    assert term.energy(made) < term.energy(clip[:, :, :24, :28].flip(1))
    mask[8:14, 8:14] = False
    masked = list(flow.published(clip, field, (24, 28), 4, mask=mask, loop=True))
    assert len(masked) == 4
    assert all(float(frame.image[:, ~mask].abs().max()) == 0 for frame in masked)


def test_a_video_that_moves_another_way_is_turned() -> None:
    down = flow.uniform(1.0, 90)(0, (24, 28))[None]
    assert int(with_variants(drifting(), down).owner.max()) == 1
    assert int(with_variants(drifting(), flow.uniform(1.0)(0, (24, 28))[None]).owner.max()) == 0


def test_what_is_not_published_is_refused() -> None:
    with pytest.raises(InputError, match="neither loops nor flows around obstacles"):
        flow.published(noise(), flow.uniform(), SHAPE, 3, loop=True)
    with pytest.raises(InputError, match="is to have 1 frame; give at least 2"):
        flow.published(drifting(), flow.uniform(1.0), (24, 28), 1)
