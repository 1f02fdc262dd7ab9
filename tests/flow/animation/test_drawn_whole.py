"""Elements of pictures that flow and keep their directions are drawn whole."""

import numpy as np
import pytest
import torch
from bench_elements import cut_elements, places_of
from discs import discs
from made import MADE
from scipy import ndimage
from textures import noise

import flow
from flow.animation import sequence
from flow.animation.film import nearest_pixels
from flow.animation.sequence import Frame

SHAPE = (72, 72)


def frames(count: int, field: flow.Field | None = None, **more: object) -> list[Frame]:
    """A pair of vortices of discs that keep their directions."""
    image, _ = discs(6, 6)
    return list(flow.animate(image, field or flow.vortices(2.0), SHAPE, frames=count, turn=False, seed=2, **more))


def whole(where: torch.Tensor) -> float:
    """Of the discs of which anything is seen away from the border, the share of which about all is."""
    _, number = discs(6, 6)
    shown, most, good, count = number[tuple(where.numpy())], np.bincount(number.ravel()), 0, 0
    for disc in np.unique(shown[shown > 0]):
        regions, found = ndimage.label(shown == disc, np.ones((3, 3)))
        for region in range(1, found + 1):
            own = np.argwhere(regions == region)
            if own.min() > 0 and own.max() < SHAPE[0] - 1:
                count += 1
                good += 0.7 < len(own) / most[disc] < 1.4
    return good / max(count, 1)


def test_elements_are_whole_that_copies_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    made = frames(24)
    for frame in made:  # what is seen is what the frame tells of
        shown = discs(6, 6)[0][(slice(None), *frame.where)]
        assert float((frame.image - shown).abs().mean()) < 0.12
    monkeypatch.setattr(sequence, "cells_that_flow", lambda _: None)
    drawn, cut = (np.mean([whole(frame.where) for frame in some]) for some in (made, frames(24)))
    assert drawn > 0.85
    assert drawn > cut + 0.1


def test_letters_are_whole_as_their_hulls_are_moved(monkeypatch: pytest.MonkeyPatch) -> None:
    made = MADE["letters"](128, 24, 2)

    def cut() -> float:
        """The share of letters that are, over a few frames."""
        frames = list(flow.animate(made.image, flow.rotation(2.0), (128, 128), frames=31, turn=False, seed=0))
        shares = [
            cut_elements(made.numbers.numpy(), places_of(made.image)[*f.source.numpy()[1:]]) for f in frames[20::5]
        ]
        return float(np.mean([each["cut"] for each in shares]))

    drawn = cut()
    monkeypatch.setattr(sequence, "cells_that_flow", lambda _: None)
    torn = cut()
    assert drawn < 0.04
    assert torn > drawn + 0.05


def test_what_does_not_flow_stays_bit_for_bit() -> None:
    first, *others = frames(3, field=flow.uniform(0, 0))
    for frame in others:
        assert torch.equal(frame.state.source, first.state.source)


def test_elements_move_as_the_flow_does() -> None:
    made = frames(2, field=flow.uniform(1.25, 90))
    moved = made[1].state.source - made[0].state.source
    inner = (slice(None), slice(8, -8), slice(8, -8))
    assert torch.allclose(moved[inner].flatten(1).median(1).values, torch.tensor([0, -1.25]), atol=0.1)


def test_what_goes_on_after_a_state_is_the_same() -> None:
    made = frames(6)
    again = frames(6, after=made[2].state)
    assert torch.equal(again[-1].image, made[-1].image)
    assert torch.equal(again[-1].where, made[-1].where)


def test_a_loop_of_them_comes_back() -> None:
    image, _ = discs(6, 6)
    made = list(flow.loop(image, flow.vortices(1.0), SHAPE, frames=8, turn=False, seed=2))
    steps = [float((a.image - b.image).abs().mean()) for a, b in zip(made, made[1:] + made[:1], strict=True)]
    assert steps[-1] < 1.5 * max(steps[:-1])
    assert np.mean([whole(frame.where) for frame in made]) > 0.8


def test_all_else_is_seen_as_it_lies() -> None:
    for frame in flow.animate(noise(3, 48, 48), flow.rotation(1.0), (48, 48), frames=3, turn=False):
        assert torch.equal(frame.where, nearest_pixels(frame.state.source, (48, 48)))
