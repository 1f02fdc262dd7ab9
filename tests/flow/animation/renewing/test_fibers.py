"""Textures that run along an axis: their blocks and windows are long, and their ends are not seen."""

import pytest
import torch
from torch import Tensor

import flow
from flow.animation import looping
from flow.animation.film.film import Film
from flow.animation.renewing.blocks import bell, inner
from flow.animation.renewing.fibers import block_sides
from flow.animation.renewing.renewal import Renewal
from flow.animation.renewing.stock import Coordinates
from flow.animation.settings import Renewing
from kwatra import Exemplar
from kwatra.elements import drawn_sides
from kwatra.pieces import SeamCost


def fibers(side: int = 96, seed: int = 0) -> Tensor:
    """Long, slim blots of three channels (3, side, side) that run from above to below."""
    noise = torch.randn(1, 3, side + 48, side, generator=torch.Generator().manual_seed(seed))
    tall = torch.nn.functional.avg_pool2d(noise, (25, 1), 1, (12, 0))
    blots = torch.nn.functional.avg_pool2d(tall, (25, 1), 1, (12, 0))[0, :, 24:-24]
    return (0.5 + 0.15 * blots / blots.std()).clamp(0, 1)


def blots(side: int = 96) -> Tensor:
    """Round ones."""
    noise = torch.randn(1, 3, side, side, generator=torch.Generator().manual_seed(1))
    return torch.nn.functional.avg_pool2d(noise, 5, 1, 2)[0].add(0.5).clamp(0, 1)


def film(image: Tensor, **how: bool) -> Film:
    return Film.of(Exemplar.of(image), **how)


def test_sides_are_drawn_out_along_the_axis_and_squares_where_there_is_none() -> None:
    assert block_sides(32, None, (96, 96)) == (32, 32)
    assert block_sides(32, 0, (96, 96)) == (64, 24)
    assert block_sides(32, 1, (96, 96)) == (24, 64)
    assert block_sides(32, 0, (50, 96)) == (50, 24)
    assert drawn_sides(16, None) == (16, 16)
    assert drawn_sides(16, 0) == (32, 4)
    assert drawn_sides(16, 1) == (4, 32)
    assert drawn_sides(2, 0) == (4, 2)  # no wider than it would be


def test_a_film_says_along_which_axis_its_picture_runs() -> None:
    assert film(fibers()).along == 0
    assert film(fibers().mT).along == 1
    assert film(blots()).along is None
    assert film(fibers(), turn=True).along is None
    assert film(fibers()[:, None].expand(-1, 5, -1, -1)).along is None  # a video


def test_prices_of_seams_follow_the_axis() -> None:
    stock = Coordinates(Exemplar.of(fibers()), 0.02, 1.0)
    one, other = (torch.tensor([[x], [40.0], [0.0]]).numpy().astype("float32") for x in (20.0, 61.0))
    plain, eased = SeamCost(stock), stock.whole(None, (1.0, 8.0))
    below, beside = ([int(cost.seam(one, other, axis, 2)[0]) for cost in (plain, eased)] for axis in (0, 1))
    assert below[0] == below[1] > 0
    assert beside[1] == beside[0] // 8 > 0


@pytest.mark.parametrize("angle", [0.0, 90.0])
def test_no_line_of_ends_is_seen_where_fibers_flow(angle: float) -> None:
    image = fibers()

    def steepest(shown: Tensor) -> float:
        return float((shown[:, 1:] - shown[:, :-1]).abs().mean((0, 2)).max())

    frames = flow.animate(image, flow.uniform(2.0, angle=angle), (96, 96), frames=30, seed=3)
    steep = [steepest(frame.image) / steepest(image) for frame in frames]
    assert sum(steep[5:]) / len(steep[5:]) < 3  # 1.2 and 1.9; 5.7 and 5.0 of square blocks with seams of one price


def test_blocks_of_what_runs_along_an_axis_are_long() -> None:
    assert Renewal(film(fibers()), (96, 96), Renewing(block=24)).blocks.sides == (48, 18)
    assert Renewal(film(blots()), (96, 96), Renewing(block=24)).blocks.sides == (24, 24)


@pytest.mark.parametrize(("side", "shape"), [(12, (8, 8)), (12, (40, 9)), (96, (20, 70)), (96, (4, 5))])
def test_small_exemplars_and_frames_are_enough(side: int, shape: tuple[int, int]) -> None:
    frames = [*flow.animate(fibers(side), flow.rotation(1.5), shape, frames=4, seed=0)]
    assert all(frame.image.shape == (3, *shape) and bool(frame.image.isfinite().all()) for frame in frames)


def test_fibers_loop_and_are_the_same_bits_for_any_number_of_threads() -> None:
    def made(threads: int) -> list[Tensor]:
        torch.set_num_threads(threads)
        return [frame.image for frame in flow.loop(fibers(64), flow.uniform(1.5, angle=90), (48, 48), frames=6)]

    one, two = made(1), made(2)
    assert len(one) == 6
    assert all(map(torch.equal, one, two))


def test_what_counts_of_a_block_falls_off_toward_its_ends() -> None:
    for weights in (bell((12, 30)), inner((12, 30))):
        assert weights.shape == (12, 30)
        assert torch.equal(weights, weights.flip(0, 1))
        assert float(weights[6, 15]) == pytest.approx(1, abs=0.02)
        assert bool((weights[6].diff()[:15] >= 0).all())
        assert bool((weights[:, 15].diff()[:6] >= 0).all())
    assert float(inner((12, 30))[0].max()) == 0
    assert float(bell((12, 30))[0, 15]) == pytest.approx(float(torch.tensor(-((5.5 / 4.8) ** 2)).exp()), rel=0.01)


def test_a_loop_that_turns_back_has_no_lines_across(monkeypatch: pytest.MonkeyPatch) -> None:
    def steepest() -> float:
        """How much more the steepest row of the frames that turn changes than their rows do."""
        frames = list(flow.loop(fibers(), flow.uniform(1.5), (80, 80), frames=16, seed=1))[9:]
        rows = torch.stack([frame.image.diff(dim=1).abs().mean((0, 2)) for frame in frames])
        return float(rows.max() / rows.mean())

    now = steepest()
    monkeypatch.setattr(looping, "easier", lambda much, along: (1.0, 1.0))
    assert now < 0.7 * steepest()
