"""Seams of what flows are hidden in the joints between large elements, though these are a texture of their own."""

import numpy as np
import pytest
import torch
from made import MADE
from scipy import ndimage

import flow
from flow.animation.carrying.copies import parted, turned
from flow.animation.film.film import Film
from flow.animation.film.joints import joints
from flow.animation.renewing.blocks import Blocks
from flow.animation.renewing.stock import Coordinates
from flow.warps import pixel_coordinates
from kwatra import Exemplar
from kwatra.elements import find_ground
from kwatra.pieces import Hidden, hidden_seams


def wall(size: int = 32) -> Exemplar:
    return Exemplar.of(MADE["bricks"](128, size, 0).image)


def through_bricks(frame: flow.Frame, numbers: np.ndarray) -> float:
    """The share of a frame's pixels beside a seam both of whose sides show bricks."""
    source = frame.state.source
    seams = parted(source, frame.state.inside, turned(source), ((0, 1), (1, 0)))[0].numpy()
    x, y = (at.clip(0, 127) for at in source.round().long().numpy())
    on = numbers[y, x] > 0
    beside, below = seams[0, :, :-1] & on[:, 1:] & on[:, :-1], seams[1, :-1] & on[1:] & on[:-1]
    return (beside.sum() + below.sum()) / on.size


def stained() -> Exemplar:
    """A wall with mortar of many colors: no net of lines is seen."""
    made = MADE["bricks"](128, 32, 0)
    hues = ndimage.gaussian_filter(np.random.default_rng(0).normal(size=(3, 128, 128)), (0, 5, 5))
    hues = torch.from_numpy(0.3 * (hues - hues.mean(0)) / hues.std() * (made.numbers.numpy() == 0)).float()
    return Exemplar.of((made.image + hues).clamp(0, 1))


def test_rough_mortar_of_large_bricks_hides_seams_of_what_flows_and_not_of_stills() -> None:
    exemplar = stained()
    found, ground = joints(exemplar), find_ground(exemplar)
    assert hidden_seams(exemplar) is None
    assert found is not None
    assert found.hides == ground.sure
    assert (found.depth[ground.depth == 1] == 1).all()
    assert np.allclose(found.depth[ground.depth == 0], 1 - ground.sure)


def test_where_mortar_lies_counts_more_in_flows_though_it_is_plain() -> None:
    found, still = joints(wall()), hidden_seams(wall())
    assert found is not None
    assert still is not None
    assert np.array_equal(found.depth, still.depth)
    assert found.aligned > still.aligned
    assert found.dearer > still.dearer


def test_joints_of_a_large_picture_are_found_where_it_is_coarser_and_size_counts_as_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen, small = joints(Exemplar.of(MADE["bricks"](128, 32, 0).image)), MADE["bricks"](128, 18, 0).image
    assert seen is not None
    large = MADE["bricks"](128, 32, 0).image.repeat_interleave(2, 1).repeat_interleave(2, 2)
    monkeypatch.setattr("kwatra.pieces.seams.gaps.LOOKED_AT", 128**2)
    found = joints(Exemplar.of(large))
    assert found is not None
    assert found[1:] == (seen.hides, 2 * seen.size, *seen[3:])
    assert np.abs(found.depth.reshape(128, 2, 128, 2).mean((1, 3)) - seen.depth).max() < 0.2
    assert joints(Exemplar.of(small)) is None
    assert joints(Exemplar.of(small.repeat_interleave(2, 1).repeat_interleave(2, 2))) is not None


def test_small_bricks_plain_ground_and_noise_are_left_as_they_are_in_stills() -> None:
    noise = torch.rand(3, 64, 64, generator=torch.Generator().manual_seed(0))
    assert joints(wall(12)) is None
    assert joints(Exemplar.of(noise)) is None
    stones = Exemplar.of(MADE["stones"](128, 24, 0).image)
    found, same = joints(stones), hidden_seams(stones)
    assert found is not None
    assert same is not None
    assert np.array_equal(found.depth, same.depth)
    assert found[1:] == same[1:]


def test_where_joints_lie_counts_as_much_more_as_is_said() -> None:
    film, found = Film.of(wall()), joints(wall())
    assert found is not None
    more = [Blocks(film, (40, 40), hidden)._compared.weights[-1] for hidden in (found, found._replace(aligned=1.0))]
    assert more[0] == found.aligned * more[1]


def test_a_seam_through_bricks_costs_as_much_more_as_is_said() -> None:
    found, stock = joints(wall()), Coordinates(wall(), 0.02, 1.2)
    assert found is not None
    costs = [stock.whole(hidden, (1.0, 1.0)).depth for hidden in (found, found._replace(dearer=1.0))]
    assert costs[0] is not None
    assert costs[1] is not None
    assert costs[0].least == found.dearer * costs[1].least > costs[1].least


def test_mortar_is_continued_rather_than_colors_of_bricks() -> None:
    made, film = MADE["bricks"](128, 32, 0), Film.of(wall())
    here = pixel_coordinates((48, 48)) + torch.tensor([40, 23]).view(2, 1, 1)
    known, free = torch.ones(1, 1, 48, 48), torch.Generator().manual_seed(0)
    blocks = Blocks(film, (48, 48), film.hidden)
    image = film.strip.canvas[:, 23:71, 40:88].mean((1, 2))[:, None, None].expand(3, 48, 48)  # which tells nothing
    x, y = blocks.nearest(blocks.seen(image, here)[None], known, lambda rows: torch.zeros(len(rows), 128), free)[0]
    shown = made.numbers[y : y + 48, x : x + 48] > 0
    assert float((shown == (made.numbers[23:71, 40:88] > 0)).float().mean()) > 0.95


@pytest.mark.parametrize("field", [flow.rotation(2.0), flow.vortices(2.0)])
def test_seams_of_a_wall_that_flows_cut_fewer_bricks(field: flow.Field, monkeypatch: pytest.MonkeyPatch) -> None:
    made, cut = MADE["bricks"](128, 32, 0), []
    for hides in (joints, lambda exemplar: None):
        monkeypatch.setattr("flow.animation.film.film.joints", hides)
        *_, last = flow.animate(made.image, field, (112, 120), frames=16, seed=1)
        cut.append(through_bricks(last, made.numbers.numpy()))
    assert cut[0] < 0.5 * cut[1]


def test_ground_is_told_by_what_is_hidden() -> None:
    found = joints(wall())
    assert isinstance(found, Hidden)
    assert found.size == find_ground(wall()).size
