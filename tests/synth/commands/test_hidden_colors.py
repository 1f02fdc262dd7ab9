"""Colors that cannot be seen, as alpha is 0 there, color nothing: whatever they are, what is seen is the same."""

from pathlib import Path

import pytest
import torch
from torch import Tensor

from synth import Kind, write_image
from synth.cli import main
from synth.io import read_image
from synth.io.videos import read_video, write_video

RGBA = Kind("uint8", ("R", "G", "B", "A"))
SIZE = 32


def texture(seed: int, hidden: float) -> Tensor:
    """Blobs (4, SIZE, SIZE) with holes, of which the hidden color is so bright."""
    noise = torch.rand(1, 4, SIZE + 4, SIZE + 4, generator=torch.Generator().manual_seed(seed))
    blobs = torch.nn.functional.avg_pool2d(noise, 5, 1)[0]
    clear = blobs[3:] < 0.5
    return torch.cat([torch.where(clear, hidden, blobs[:3]), (~clear).float()])


def seen(pixels: Tensor) -> Tensor:
    return pixels[:3] * pixels[3:]


@pytest.mark.parametrize(
    "words",
    [
        ["morph", "a.png", "b.png", "--at", "0.5", "--method", "blend"],
        ["morph", "a.png", "b.png", "--at", "1,1", "--preset", "fast"],
        ["quilt", "a.png", "--feather", "2"],
        ["merge", "a.png", "b.png", "--keep", "keep.png", "--feather", "2"],
        ["synth", "a.png", "--preset", "fast"],
        ["tile", "a.png"],
    ],
)
def test_of_images(words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    keep = torch.zeros(1, SIZE, SIZE)
    keep[:, 12:20, 12:20] = 1
    write_image("keep.png", keep, Kind("uint8", ("Y",)))
    made = []
    for hidden in (0.0, 1.0):
        write_image("a.png", texture(1, hidden), RGBA, overwrite=True)
        write_image("b.png", texture(2, hidden), RGBA, overwrite=True)
        assert main([*words, "-o", "out.png", "--overwrite"]) == 0
        made.append(seen(read_image("out.png").pixels))
    assert torch.equal(made[0], made[1])
    assert float(made[0].std()) > 0.1


def test_of_videos_that_are_quilted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    made = []
    for hidden in (0.0, 1.0):
        picture = texture(1, hidden)
        write_video("clip", torch.stack([picture.roll(t, 2) for t in range(8)], 1), 25.0, RGBA, overwrite=True)
        assert main(["quilt", "clip", "--mode", "time", "--frames", "10", "-o", "out", "--overwrite"]) == 0
        made.append(seen(read_video("out").frames))
    assert torch.equal(made[0], made[1])
    assert float(made[0].std()) > 0.1
