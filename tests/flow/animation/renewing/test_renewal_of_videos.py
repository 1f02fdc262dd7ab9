"""What renewal heeds of videos: how grainy they are, and where in their frames texture came from."""

from dataclasses import replace
from typing import Any

import torch
from skimage import data

from flow.animation.film.film import Film
from flow.animation.renewing.renewal import Renewal
from flow.animation.settings import Renewing
from flow.warps.warp import pixel_coordinates
from kwatra import Exemplar

SHAPE = (60, 64)
WHOLE = torch.ones(SHAPE, dtype=torch.bool)
QUICK = Renewing(blocks=6, block=24, window=12, step=6, tones=0, flow_weight=0.025)


def test_where_a_video_is_shown_without_its_grain_grainy_texture_is_cheaper() -> None:
    x, y = pixel_coordinates((64, 128))
    frame = 0.3 + 0.4 * y / 63 + torch.where(x < 64, 0.0, 0.2) * (1 - 2 * ((x + y) % 2))
    film = Film.of(Exemplar.of(frame.expand(1, 4, 64, 128)))
    renewal = Renewal(film, SHAPE, replace(QUICK, tones=1.0, usage=0, aging=0))
    costs = renewal._using(renewal.begin(pixel_coordinates(SHAPE), WHOLE))(torch.arange(8, 48))
    smooth, grainy = costs[:, 8:56].mean(), costs[:, 72:120].mean()
    assert float(smooth) > float(grainy) + renewal.wear.variance


def test_of_a_scene_a_block_comes_from_where_its_spot_belongs() -> None:
    brick = torch.from_numpy(data.brick()[:96, :96] / 255).float()
    film = replace(Film.of(Exemplar.of(brick.expand(1, 6, 96, 96))), scene=True)
    renewal, (x, y) = Renewal(film, SHAPE, QUICK), pixel_coordinates(SHAPE)
    place, spot = torch.stack([x + 11, y + 3]), (slice(10, 34), slice(20, 44))
    frame = renewal.begin(torch.stack([x + 11, y + 8 + 2 * film.pitch]), WHOLE, place=place)
    home = renewal._home(frame, spot)
    assert home is not None
    assert home.tolist() == [31.0, 13.0]
    entering = renewal.begin(torch.stack([x - 11, y + 3 + 2 * film.pitch]), WHOLE, place=place)
    assert renewal._home(entering, (slice(10, 34), slice(0, 24))) is None
    assert renewal._home(renewal.begin(frame.source, WHOLE), spot) is None
    asked: list[Any] = []
    renewal.blocks.nearest = lambda *given: asked.append(given[4]) or torch.zeros(1, 2)  # type: ignore
    renewal._renew(frame, [(10, 20)], torch.Generator())
    assert asked[0][0].tolist() == [31.0, 13.0]
