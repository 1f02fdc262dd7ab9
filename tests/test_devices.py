"""Everything that is computed elsewhere than on the CPU mixes no tensors of two devices (see `elsewhere`)."""

from collections.abc import Callable, Iterator

import numpy as np
import pytest
import torch
from elsewhere import NAME, elsewhere
from torch import Tensor

import flow
import kwatra
import synth

Made = Callable[[str], Tensor]


def stones(height: int = 40, width: int = 48) -> Tensor:
    """A picture (3, H, W) with elements: soft blobs on dark ground."""
    noise = torch.rand(3, 6, 7, generator=torch.Generator().manual_seed(0))
    return torch.nn.functional.interpolate(noise[None], (height, width), mode="bicubic")[0].clamp(0, 1)


def oblique() -> Tensor:
    """Lines that run a pixel to the right for each two down."""
    tones = torch.rand(3, 80, generator=torch.Generator().manual_seed(3))
    return tones[:, torch.arange(48) - torch.arange(40)[:, None] // 2 + 20]


def tiles() -> Tensor:
    """A picture (3, H, W) with a lattice, not exactly periodic."""
    cell = stones()[:, :10, :12].repeat(1, 4, 4)
    return cell + 0.05 * torch.rand(cell.shape, generator=torch.Generator().manual_seed(1))


def cloth() -> Tensor:
    """Lines that run through, across lines that do."""
    tones = torch.rand(3, 88, generator=torch.Generator().manual_seed(1)) / 2
    return tones[:, :40, None] + tones[:, None, 40:]


def clip() -> Tensor:
    """A video (1, T, H, W) that drifts."""
    return torch.stack([stones(24, 32)[:1].roll(t, 2) for t in range(4)], 1)


def still(**options: object) -> Made:
    given, size = options.pop("exemplar", stones()), options.pop("size", (44, 48))
    settings = {"preset": "fast", **options}
    return lambda device: synth.synthesize(given, size, device=device, **settings).image


def ranked(device: str) -> Tensor:
    torch.set_num_threads(1)  # what is made believe is so in this thread alone
    return still(preset="default", size=(24, 24))(device)


def steered(device: str) -> Tensor:
    known, where = torch.full((3, 44, 48), 0.5), torch.zeros(3, 44, 48, dtype=torch.bool)
    where[:, :10] = True
    terms = kwatra.HardPixels(known.to(device), where.to(device))
    soft = kwatra.SoftPixels(known.to(device), torch.full((1, 44, 48), 0.02, device=device))
    mask = np.hypot(*(np.indices((44, 48)) - 22)) > 6
    return still(terms=terms + soft, mask=mask)(device)


def guided(device: str) -> Tensor:
    return synth.synthesize(stones(), guide=(stones()[:1], stones().mT[:1]), preset="fast", device=device).image


def filled(device: str) -> Tensor:
    hole = np.hypot(*(np.indices((40, 48)) - 20)) < 7
    return synth.fill(stones(), hole, preset="fast", device=device).image


def voted(device: str) -> Tensor:
    exemplar = kwatra.Exemplar.of(stones(), device=device)
    votes = (kwatra.mean, kwatra.Mode(0.1), kwatra.CheapestSeams())
    settings = [kwatra.Settings(levels=(kwatra.Level(1, 8, 1),), vote=vote) for vote in votes]
    return torch.cat([kwatra.optimize(exemplar, (24, 32), settings=s, start="windows").image.cpu() for s in settings])


def last(frames: Iterator[kwatra.Result]) -> Tensor:
    return list(frames)[-1].image


def flowing(given: Tensor, field: flow.Field, **options: object) -> Made:
    return lambda device: last(
        flow.animate(kwatra.Exemplar.of(given, device=device), field, (32, 40), frames=2, **options)
    )


def resumed(device: str) -> Tensor:
    """A frame behind a state that was kept."""
    exemplar, field = kwatra.Exemplar.of(clip()), flow.uniform(2.0)
    state = next(flow.animate(exemplar, field, (32, 40), frames=1)).state
    return last(flow.animate(exemplar.to(device), field, (32, 40), frames=2, after=state))


def published(given: Tensor) -> Made:
    return lambda device: last(
        flow.published(kwatra.Exemplar.of(given, device=device), flow.uniform(1.0), (24, 32), 2)
    ).cpu()


def morphed(method: str, **options: object) -> Made:
    a, b = stones()[:, :16, :16], stones()[:, 16:32, 16:32]
    settings = {"preset": "fast", **options}
    return lambda device: torch.stack(synth.morph(a, b, 2, method=method, device=device, **settings).frames)


CASES = {
    "tiled": still(tile=True),
    "lattice": still(exemplar=tiles()),
    "oblique lines": still(exemplar=oblique()),
    "cloth": still(exemplar=cloth()),
    "variants of two": still(exemplar=[stones(), tiles()], mirror=True, rotate=(30.0,)),
    "the best of three": ranked,
    "steered": steered,
    "guided": guided,
    "filled": filled,
    "voted": voted,
    "video in its place": still(exemplar=clip(), size=(5, 24, 32), stay=1.0, loop=True),
    "turning": flowing(stones(), flow.rotation(2.0), turn=True, also=stones()[:1]),
    "flowing on": resumed,
    "flowing video": flowing(clip(), flow.uniform(2.0)),
    "published": published(stones()),
    "published video": published(clip()),
    "control": morphed("control", iterations=3, steps=2),
    "blend": morphed("blend", retexture=True),
}


@pytest.mark.usefixtures("in_turn")  # the device is there in one thread alone
@pytest.mark.parametrize("name", CASES)
def test_elsewhere_it_is_made_too(name: str) -> None:
    with elsewhere() as device:
        made = CASES[name](NAME).cpu()
    assert device.moved
    assert made.isfinite().all()
    assert made.std() > 0.05


def test_tensors_move_seldom():
    with elsewhere() as device:
        still(exemplar=tiles(), size=(96, 96))(NAME)
    assert device.moved < 200


def test_two_devices_are_told_apart():
    here = torch.rand(3, 4)
    with elsewhere() as device:
        there = here.to(NAME)
        assert there.device.type == NAME
        assert (there + there).cpu().equal(here + here)
        with pytest.raises(RuntimeError, match="two devices"):
            there + here
        with pytest.raises(RuntimeError, match="two devices"):
            here[there.argmax(0)]
        with pytest.raises(RuntimeError, match="two devices"):
            there[:, there[0] > 2] = here[:, :1]
        with pytest.raises(RuntimeError, match="generator"):
            torch.rand(3, device=NAME, generator=torch.Generator())
        assert device.moved >= 2
