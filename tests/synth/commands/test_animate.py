"""`kwatra animate`: what it writes."""

import os
from pathlib import Path

import pytest
import torch
from sand import GRAY, QUICK, RGB, SAND, SHAPE, frames_of, texture, written

import flow
from kwatra import Exemplar
from synth import Kind, read_image, write_image
from synth.cli import main
from synth.io import flow_formats
from synth.io.images import read_array
from synth.io.videos import read_video
from synth.texture.illumination import under_even_light
from synth.texture.work import PRESETS


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with an exemplar and a flow."""
    monkeypatch.chdir(tmp_path)
    written()
    return tmp_path


def test_the_frames_are_those_of_the_engine(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*SAND, "--frames", "3", "--seed", "5", "--speed", "1", "-o", "out"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("wrote out: 3 frames of 48x40 in ")
    assert out.endswith(" s per frame)\n")
    assert err == ""
    pixels = read_image("sand.png").pixels
    low, high = float(pixels.min()), float(pixels.max())
    expected = flow.animate(
        Exemplar.of((pixels - low) / (high - low)),
        flow.rotation(1.0),
        SHAPE,
        frames=3,
        renewing=flow.PRESETS["fast"],
        synthesis=PRESETS["fast"][0],
        seed=5,
    )
    for number, frame in enumerate(expected):
        made = read_image(f"out/{number:06d}.png")
        assert made.kind == GRAY
        torch.testing.assert_close(made.pixels, frame.image * (high - low) + low, rtol=0, atol=0.51 / 255)
    assert sorted(os.listdir("out")) == [".state.npz", "000000.png", "000001.png", "000002.png"]


@pytest.mark.parametrize(("name", "rate"), [("out.mp4", 20.0), ("out.gif", 20.0)])
def test_a_video_shows_the_frames_and_nothing_else_is_left(folder: Path, name: str, rate: float) -> None:
    assert main([*SAND, "--frames", "3", "-o", "out"]) == 0
    before = set(folder.iterdir())
    assert main([*SAND, "--frames", "3", "-o", name, "--fps", "20"]) == 0
    assert set(folder.iterdir()) - before == {folder / name}
    clip = read_video(name)
    assert clip.rate == pytest.approx(rate)
    assert clip.frames.shape == (3, 3, *SHAPE)
    torch.testing.assert_close(clip.frames, read_video("out").frames.expand(3, -1, -1, -1), rtol=0, atol=0.1)


def test_output_goes_to_the_current_folder_named_after_exemplar_and_flow(folder: Path) -> None:
    Path("deep").mkdir()
    write_image("deep/mud.png", texture(), GRAY)
    assert main(["animate", "deep/mud.png", "--flow", "uniform:90", "--frames", "2", *QUICK]) == 0
    assert main(["animate", "deep/mud.png", "--flow", "wind.flo", "--frames", "2", "--preset", "fast"]) == 0
    assert read_video("mud_uniform90.mp4").frames.shape == (3, 2, *SHAPE)
    assert read_video("mud_wind.mp4").frames.shape == (3, 2, 30, 36)  # the flow's own size


def test_a_flow_file_is_read_once(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read, opened = flow_formats.READERS[".flo"], []
    monkeypatch.setitem(flow_formats.READERS, ".flo", lambda path: opened.append(path) or read(path))
    assert main(["animate", "sand.png", "--flow", "wind.flo", "--frames", "2", "--preset", "fast"]) == 0
    assert opened == [Path("wind.flo")]


@pytest.mark.parametrize(
    "kind", [Kind("uint16", ("R", "G", "B", "A")), Kind("float32", ("R", "G", "B")), Kind("bool", ("Y",))]
)
def test_frames_are_of_the_exemplars_kind(folder: Path, kind: Kind) -> None:
    scale, suffix = (7.0, ".tif") if kind.dtype == "float32" else (1.0, ".png")
    write_image(f"in{suffix}", texture(len(kind.channels)) * scale, kind)
    assert main(["animate", f"in{suffix}", "--flow", "sink", *QUICK, "--frames", "2", "-o", "out"]) == 0
    made, source = read_image(f"out/000001{suffix}"), read_image(f"in{suffix}")
    assert made.kind == kind
    assert abs(float(made.pixels.mean() - source.pixels.mean())) < 0.1 * scale


def test_a_video_of_floats_goes_from_their_least_to_their_largest(folder: Path) -> None:
    exemplar = texture(3) * 7 - 2
    write_image("in.tif", exemplar, Kind("float32", RGB.channels))
    for output in ("out.mp4", "out"):
        assert main(["animate", "in.tif", "--flow", "sink", *QUICK, "--frames", "2", "-o", output]) == 0
    values = torch.stack([read_image(path).pixels for path in sorted(Path("out").glob("*.tif"))], 1)
    shown = (values - exemplar.min()) / (exemplar.max() - exemplar.min())
    assert float(read_video("out.mp4").frames.mean()) == pytest.approx(float(shown.mean()), abs=0.02)


def test_a_loop_has_its_frames(folder: Path) -> None:
    assert main([*SAND, "--loop", "4", "-o", "out"]) == 0
    frames = frames_of("out")
    assert len(frames) == 4
    assert len(set(frames)) == 4


def test_the_first_frame_may_be_given(folder: Path) -> None:
    write_image("start.png", texture(size=96)[:, :50, :60], GRAY)
    assert main(["animate", "sand.png", "--flow", "sink", "--first", "start.png", "--frames", "1", "-o", "out"]) == 0
    made = read_image("out/000000.png").pixels
    assert made.shape == (1, 50, 60)
    close, other = read_image("start.png").pixels, read_image("start.png").pixels.roll((9, 9), (1, 2))
    assert float((made - close).square().mean()) < 0.7 * float((made - other).square().mean())


def test_texture_enters_an_empty_frame(folder: Path) -> None:
    arguments = ["animate", "sand.png", "--flow", "uniform", "--speed", "4", "--fill-from", "left", *QUICK]
    assert main([*arguments, "--frames", "4", "-o", "out"]) == 0
    first, last = (read_image(f"out/{number:06d}.png").pixels[0] for number in (0, 3))
    assert float(first.max()) == 0
    assert float((last[:, :12] > 0).float().mean()) > 0.9
    assert float(last[:, 12:].max()) == 0


@pytest.mark.parametrize("drawn", [False, True])
def test_the_obstacle_is_gray_and_nothing_flows_into_it(folder: Path, drawn: bool) -> None:
    mask = flow.disc_mask(SHAPE, (20.0, 15.0), 8.0)
    write_image("stone.png", (~mask).float()[None], GRAY)
    obstacle = "stone.png" if drawn else "disc:20,15,8"
    arguments = ["animate", "sand.png", "--flow", "uniform", "--obstacle", obstacle, "--preset", "fast"]
    assert main([*arguments, "--size", "48x40", "--frames", "2", "-o", "out"]) == 0
    made = read_array("out/000001.png")[0][..., 0]
    assert (made[~mask.numpy()] == 128).all()
    assert (made[mask.numpy()] != 128).mean() > 0.9
    pixels = read_image("sand.png").pixels
    bent = flow.around(flow.uniform(), mask)
    settings = {"mask": mask, "renewing": flow.PRESETS["fast"], "synthesis": PRESETS["fast"][0], "frames": 2}
    low, high = float(pixels.min()), float(pixels.max())
    *_, last = flow.animate(Exemplar.of((pixels - low) / (high - low)), bent, SHAPE, **settings)
    expected = (last.image * (high - low) + low)[0][mask]
    torch.testing.assert_close(torch.from_numpy(made)[mask] / 255, expected, rtol=0, atol=0.51 / 255)


def test_what_is_empty_is_transparent_where_there_is_alpha(folder: Path) -> None:
    pixels = torch.cat([texture(3), torch.ones(1, 64, 64)])
    write_image("in.png", pixels, Kind("uint8", ("R", "G", "B", "A")))
    arguments = ["animate", "in.png", "--flow", "uniform", "--obstacle", "disc", "--fill-from", "left", *QUICK]
    assert main([*arguments, "--frames", "2", "-o", "out"]) == 0
    assert not read_array("out/000000.png")[0].any()
    made = read_array("out/000001.png")[0]
    assert (made[:, 0, 3] == 255).mean() > 0.9
    assert not made[:, 10:].any()


def test_a_flow_of_another_size_is_stretched_on_request(folder: Path) -> None:
    arguments = ["animate", "sand.png", "--flow", "wind.flo", "--frames", "2", *QUICK]
    assert main([*arguments, "-o", "out", "--resample", "--speed", "2"]) == 0
    assert read_image("out/000001.png").pixels.shape == (1, *SHAPE)


def test_elements_turn_or_keep_their_directions_as_asked(folder: Path) -> None:
    exemplar = read_image("sand.png").pixels
    low, high = float(exemplar.min()), float(exemplar.max())
    for asked in (True, False):
        assert main([*SAND, "--frames", "2", "--turn", "on" if asked else "off", "-o", f"out{asked}"]) == 0
        *_, frame = flow.animate(
            (exemplar - low) / (high - low), flow.rotation(2.0), SHAPE, frames=2, renewing=flow.PRESETS["fast"],
            synthesis=PRESETS["fast"][0], turn=asked
        )  # fmt: skip
        made = read_image(f"out{asked}/000001.png").pixels
        torch.testing.assert_close(made, frame.image * (high - low) + low, rtol=0, atol=0.51 / 255)
    assert not torch.equal(*(read_image(f"out{asked}/000001.png").pixels for asked in (True, False)))


def test_light_that_falls_unevenly_on_an_exemplar_does_not_flow(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lit = texture(size=80) * torch.linspace(0.4, 1, 80)
    write_image("lit.png", lit, GRAY)
    given = ["--flow", "uniform", *QUICK, "--frames", "2"]
    assert main(["animate", "lit.png", *given, "-o", "out"]) == 0
    pixels = read_image("lit.png").pixels
    low, high = float(pixels.min()), float(pixels.max())
    even = under_even_light(Exemplar.of((pixels - low) / (high - low)), low / (high - low))
    first, _ = flow.animate(
        even, flow.uniform(), SHAPE, frames=2, renewing=flow.PRESETS["fast"], synthesis=PRESETS["fast"][0], seed=0
    )
    made = read_image("out/000000.png").pixels
    torch.testing.assert_close(made, first.image * (high - low) + low, rtol=0, atol=0.51 / 255)
    monkeypatch.delattr("synth.commands.animate_inputs.under_even_light")  # what is begun with may be lit alike
    assert main(["animate", "lit.png", *given, "--first", "out/000000.png", "-o", "begun"]) == 0
    published = ["animate", "lit.png", "--flow", "uniform", "--size", "48x40", "--frames", "1", "--published"]
    assert main([*published, "--mirror", "-o", "mirrored"]) == 0  # nor was light evened then, of variants or none
