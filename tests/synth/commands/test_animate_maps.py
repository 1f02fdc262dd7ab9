"""`kwatra animate` with maps that go along, several exemplars, and a background."""

import itertools
import math
import re
from collections.abc import Callable
from pathlib import Path

import pytest
import torch

import flow
from flow.warps import pixel_coordinates
from synth import Kind, read_image, write_image
from synth.cli import main
from synth.commands.animate_maps import read_along
from synth.io.videos import read_video, write_video

GRAY, RGB, DEEP = Kind("uint8", ("Y",)), Kind("uint8", ("R", "G", "B")), Kind("uint16", ("Y",))
QUICK = ["--size", "48x40", "--preset", "fast", "--frames", "4"]
SAND = ["animate", "sand.png", "--flow", "rotation", *QUICK]


def texture(seed: int = 0, size: int = 64) -> torch.Tensor:
    noise = torch.rand(1, 1, size // 2, size // 2, generator=torch.Generator().manual_seed(seed))
    return torch.nn.functional.interpolate(noise, (size, size), mode="bicubic")[0].clamp(0, 1) * 0.8 + 0.2


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_image("sand.png", texture(), GRAY)
    write_image("deep.png", texture(), DEEP)
    write_image("red.png", torch.stack([texture(1)[0], texture(2)[0], texture(3)[0]]), RGB)
    write_image("small.png", texture(4, 32), GRAY)
    write_image("normals.png", torch.tensor([1.0, 0.5, 0.7]).view(3, 1, 1).expand(3, 64, 64), RGB)
    return tmp_path


def frames(name: str) -> list[torch.Tensor]:
    return [read_image(path).pixels for path in sorted(Path(name).glob("[0-9]*"))]


def test_a_map_of_the_picture_itself_flows_as_it_does_and_changes_nothing(folder: Path) -> None:
    assert main([*SAND, "-o", "plain"]) == 0
    assert main([*SAND, "-o", "out", "--also", "depth=deep.png", "--also", "id=red.png"]) == 0
    for plain, out, deep in zip(frames("plain"), frames("out"), frames("out_depth"), strict=True):
        assert torch.equal(plain, out)
        torch.testing.assert_close(deep, out, rtol=0, atol=1.1 / 255)
    assert read_image("out_depth/000003.png").kind == DEEP
    assert read_image("out_id/000003.png").kind == RGB
    assert main([*SAND, "-o", "film.mp4", "--also", "id=red.png"]) == 0
    assert read_video("film_id.mp4").frames.shape == (3, 4, 40, 48)
    assert sorted(path.name for path in folder.iterdir() if path.name.startswith("film")) == ["film.mp4", "film_id.mp4"]


@pytest.mark.parametrize("length", [["--frames", "6"], ["--loop", "6"]])
def test_maps_are_gone_on_with(folder: Path, monkeypatch: pytest.MonkeyPatch, length: list[str]) -> None:
    command = ["animate", "sand.png", "--flow", "rotation", *QUICK[:4], *length, "--also", "id=red.png"]
    assert main([*command, "-o", "whole"]) == 0
    name = length[0][2:] if length[0] == "--loop" else "animate"
    make = getattr(flow, name)

    def some(*arguments: object, **named: object) -> object:
        yield from itertools.islice(make(*arguments, **named), 2)
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(flow, name, some)
        assert main([*command, "-o", "parts"]) == 130
    assert main([*command, "-o", "parts", "--resume"]) == 0
    for kind in ("", "_id"):
        for one, other in zip(frames(f"whole{kind}"), frames(f"parts{kind}"), strict=True):
            assert torch.equal(one, other)


def test_normals_turn_as_the_flow_turns_what_they_belong_to(folder: Path) -> None:
    along = read_along("normal=normals.png", [texture()], Path("out"))
    angle = math.radians(20)
    turn = torch.tensor([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    source = 30 + torch.einsum("ij,jhw->ihw", turn, pixel_coordinates((40, 48), torch.device("cpu")))
    shown = torch.ones(40, 48, dtype=torch.bool)
    values = along.values[0][:, :1, :1].expand(3, 40, 48)
    x, y, z = along.drawn(values, source, shown)
    assert float((2 * x - 1).mean()) == pytest.approx(math.cos(angle), abs=0.01)  # counterclockwise: up, and y is up
    assert float((2 * y - 1).mean()) == pytest.approx(math.sin(angle), abs=0.01)
    assert float((z - 0.7).abs().max()) < 0.01
    down = read_along("normal_dx=normals.png", [texture()], Path("out"))
    assert float((2 * down.drawn(values, source, shown)[1] - 1).mean()) == pytest.approx(-math.sin(angle), abs=0.01)
    assert torch.equal(along.drawn(values, source, ~shown), torch.zeros(3, 40, 48))


def test_several_exemplars_flow_together_with_their_maps(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_image("none.png", torch.zeros(1, 64, 64), DEEP)
    command = ["animate", "sand.png", "red.png", "--flow", "rotation", "--size", "96x96", *QUICK[2:]]
    command += ["--also", "id=deep.png,none.png"]
    assert main([*command, "-o", "out"]) == 0
    assert read_image("out/000000.png").kind == RGB  # the richer one
    told = re.search(r"; of it sand.png (\d+)%, red.png (\d+)%\n", capsys.readouterr().out)
    assert told is not None
    picture, number = frames("out")[0], frames("out_id")[0][0]
    of_sand = sum(float((frame[0] > 0).float().mean()) for frame in frames("out_id")) / len(frames("out_id"))
    assert abs(int(told[1]) - 100 * of_sand) < 10
    assert int(told[1]) + int(told[2]) in (99, 100, 101)
    gray = (picture.amax(0) - picture.amin(0)) < 0.004
    assert 0 < float(gray.float().mean()) < 1
    assert float(number[gray].mean()) > 10 * float(number[~gray].mean())


def test_the_background_is_seen_behind_the_obstacle_and_before_texture_comes(folder: Path) -> None:
    behind = torch.linspace(0, 1, 48).expand(1, 40, 48)
    write_image("behind.png", behind, GRAY)
    write_image("wall.png", (torch.arange(48) > 30).float().expand(1, 40, 48), GRAY)
    options = ["--obstacle", "wall.png", "--background", "behind.png"]
    assert main([*SAND, "-o", "out", *options]) == 0
    assert main([*SAND, "-o", "plain", "--obstacle", "wall.png"]) == 0
    seen = read_image("behind.png").pixels
    for out, plain in zip(frames("out"), frames("plain"), strict=True):
        assert torch.equal(out[..., 31:], seen[..., 31:])
        assert torch.equal(out[..., :31], plain[..., :31])
    command = ["animate", "sand.png", "--flow", "uniform", *QUICK, "--fill-from", "left", "--background", "behind.png"]
    assert main([*command, "-o", "filling"]) == 0
    assert torch.equal(frames("filling")[0], seen)
    assert torch.equal(frames("filling")[3][..., 20:], seen[..., 20:])
    assert not torch.equal(frames("filling")[3][..., :4], seen[..., :4])
    write_image("color.png", torch.cat([behind, 1 - behind, behind]), RGB)
    assert main([*SAND, "-o", "raised", "--obstacle", "wall.png", "--background", "color.png"]) == 0
    assert torch.equal(frames("raised")[2][..., 31:], read_image("color.png").pixels[..., 31:])


def test_maps_of_videos_go_along(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    clip = torch.stack([texture(k, 48)[:, :40] for k in range(4)], 1)
    write_video("living", clip, 10.0, GRAY)
    write_video("depth", 1 - clip, 10.0, GRAY)
    command = ["animate", "living", "--flow", "rotation", "--preset", "fast", "--frames", "3", "--speed", "1"]
    assert main([*command, "-o", "strong", "--also", "depth=depth"]) == 0
    monkeypatch.setattr("flow.animation.showing.feathering.strengthened", lambda mean, *_: mean)
    assert main([*command, "-o", "out", "--also", "depth=depth"]) == 0
    plain, strong = frames("out")[0], frames("strong")[0]
    torch.testing.assert_close(frames("out_depth")[0], 1 - plain, rtol=0, atol=2.01 / 255)
    assert len(frames("out_depth")) == 3
    assert not torch.equal(strong, plain)  # details are kept strong in what is seen, and in no map
    assert torch.equal(frames("strong_depth")[0], frames("out_depth")[0])


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("--background red.png", "is seen where there is no texture, but there is some everywhere; leave it out"),
        ("--obstacle disc --background red.png", "red.png is 64x64 but the frames are to be 48x40"),
        ("--also id=small.png", "small.png is 32x32 but its exemplar is 64x64; a map has its exemplar's size"),
        ("--also id", "--also is 'id'; write NAME=FILE"),
        ("--also a=red.png --also a=red.png", "would be written twice"),
        ("--published --also a=red.png", "leave it out"),
    ],
)
def test_what_makes_no_sense_is_refused(folder: Path, refused: Callable[..., str], words: str, sentence: str) -> None:
    assert sentence in refused(*SAND, "-o", "out", *words.split())


def test_two_videos_and_a_folder_of_maps_that_lacks_frames_are_refused(
    folder: Path, refused: Callable[..., str]
) -> None:
    write_video("living", texture()[:, None, :40, :48].expand(1, 4, 40, 48), 10.0, GRAY)
    assert "only one is animated" in refused("animate", "sand.png", "living", *SAND[2:])
    assert main([*SAND, "-o", "out", "--also", "id=red.png"]) == 0
    for file in Path("out_id").iterdir():
        file.unlink()
    words = but_longer([*SAND, "-o", "out", "--also", "id=red.png", "--resume"])
    assert "out_id has fewer frames than out" in refused(*words)


def but_longer(command: list[str]) -> list[str]:
    return ["8" if before == "--frames" else word for before, word in zip(["", *command], command, strict=False)]


def test_a_recipe_knows_the_frames_that_were_written(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*SAND, "-o", "out", "--also", "id=red.png", "--save-recipe", "sand.toml"]) == 0
    text = Path("sand.toml").read_text()
    assert '"out" = ' in text
    assert '"out_id" = ' in text
    assert main(["run", "sand.toml", "--overwrite"]) == 0
    assert capsys.readouterr().out.endswith("the same bits as then\n")
