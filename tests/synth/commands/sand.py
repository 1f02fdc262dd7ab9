"""What the tests of `kwatra animate` share: an exemplar, a flow, and runs that are interrupted."""

import itertools
from pathlib import Path

import pytest
import torch

import flow
from synth import Kind, write_flow, write_image

GRAY, RGB = Kind("uint8", ("Y",)), Kind("uint8", ("R", "G", "B"))
SHAPE = (40, 48)
QUICK = ["--size", "48x40", "--preset", "fast"]
SAND = ["animate", "sand.png", "--flow", "rotation", *QUICK]


def texture(channels: int = 1, size: int = 64) -> torch.Tensor:
    """Noise with grains of some pixels, (channels, size, size) in [0.2, 1]."""
    generator = torch.Generator().manual_seed(0)
    noise = torch.rand(1, channels, size // 2, size // 2, generator=generator)
    return torch.nn.functional.interpolate(noise, (size, size), mode="bicubic")[0].clamp(0, 1) * 0.8 + 0.2


def written() -> None:
    """Write a gray exemplar, sand.png, and a flow, wind.flo, of another size than QUICK's, into the current folder."""
    write_image("sand.png", texture(), GRAY)
    write_flow("wind.flo", flow.sink(1.0)(0.0, (30, 36)))


def but(command: list[str], changed: str) -> list[str]:
    """A command with other options, in place of those that it has."""
    given = command[:2]
    for name, value in zip(command[2::2], command[3::2], strict=True):
        given += [] if name in changed.split() else [name, value]
    return [*given, *changed.split()]


def frames_of(folder: str) -> list[bytes]:
    return [path.read_bytes() for path in sorted(Path(folder).glob("[0-9]*"))]


def interrupted(patch: pytest.MonkeyPatch, name: str, after: int) -> None:
    """Let Ctrl-C come when so many frames have been taken from flow.animate or flow.loop."""
    whole = getattr(flow, name)

    def make(*arguments: object, **named: object) -> object:
        yield from itertools.islice(whole(*arguments, **named), after)
        raise KeyboardInterrupt

    patch.setattr(flow, name, make)
