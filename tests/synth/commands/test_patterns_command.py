"""`kwatra patterns`: what it writes, takes back, and refuses."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from bench_patterns import made
from skimage import data

from synth import Kind, read_image, write_image
from synth.cli import main
from synth.metamorphosis.patterns import read_patterns

RGB = Kind("uint8", ("R", "G", "B"))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder with discs.png, flat.png, and the landmarks of one disc."""
    monkeypatch.chdir(tmp_path)
    discs = made("disc", size=128, noise=0.04)
    write_image("discs.png", torch.from_numpy(discs.image).permute(2, 0, 1).float(), RGB)
    write_image("flat.png", torch.tensor([0.8, 0.5, 0.2]).view(3, 1, 1).expand(3, 64, 64), RGB)
    one = {"format": "kwatra patterns", "version": 1, "width": 128, "height": 128}
    Path("one.json").write_text(json.dumps(one | {"landmarks": discs.landmarks[0].tolist()}))
    Path("flat.json").write_text(json.dumps(one | {"width": 64, "height": 64, "landmarks": [[9, 9], [20, 9], [9, 20]]}))
    Path("strange.json").write_text(json.dumps(one | {"landmarks": [[9, 9], [20, 9], [9, 20]], "colour": 1}))
    return tmp_path


@pytest.mark.parametrize("landmarks", [(), ("--landmarks", "one.json")])
def test_elements_are_found_and_drawn(folder: Path, capsys: pytest.CaptureFixture[str], landmarks: tuple[str]) -> None:
    assert main(["patterns", "discs.png", *landmarks, "--picture", "seen.png"]) == 0
    there = len(made("disc", size=128, noise=0.04).landmarks)
    assert f"wrote discs_patterns.json and seen.png: {there} patterns" in capsys.readouterr().out
    assert len(read_patterns("discs_patterns.json").found) == there
    seen = read_image("seen.png").pixels
    assert tuple(seen.shape) == (3, 512, 512)
    assert float(((seen[0] > 0.8) & (seen[1] < 0.3) & (seen[2] > 0.8)).float().mean()) > 0.005  # magenta lines


def test_what_cannot_be_seen_is_no_pattern(folder: Path, refused: Callable[..., str]) -> None:
    colors = read_image("discs.png").pixels
    for name, alpha in (("clear.png", torch.zeros(1, 128, 128)), ("opaque.png", torch.ones(1, 128, 128))):
        write_image(name, torch.cat([colors, alpha]), Kind("uint8", ("R", "G", "B", "A")))
    assert "found 0 patterns in clear.png" in refused("patterns", "clear.png")
    assert main(["patterns", "discs.png"]) == main(["patterns", "opaque.png"]) == 0
    assert Path("opaque_patterns.json").read_bytes() == Path("discs_patterns.json").read_bytes()


def test_what_is_hardly_distinct_is_drawn_but_not_morphed_unseen(
    folder: Path, capsys: pytest.CaptureFixture[str], refused: Callable[..., str]
) -> None:
    write_image("grass.png", torch.from_numpy(data.grass()[None, :64, :64]) / 255, Kind("uint8", ("Y",)))
    assert main(["patterns", "grass.png"]) == 0
    assert "below 0.24 they are hardly distinct: look at them" in capsys.readouterr().out
    ways = ("--method", "patterns", "--frames", "2", "-o", "film.png")
    assert "look at what `kwatra patterns` finds and give its file" in refused("morph", "grass.png", "discs.png", *ways)
    assert main(["morph", "grass.png", "grass.png", "--patterns", *["grass_patterns.json"] * 2, *ways]) == 0


def test_an_edited_file_is_taken_as_it_is(folder: Path) -> None:
    assert main(["patterns", "discs.png"]) == 0
    edited = json.loads(Path("discs_patterns.json").read_text())
    del edited["patterns"][2]
    edited["patterns"][0][0][0] += 1.5
    Path("edited.json").write_text(json.dumps(edited))
    assert main(["patterns", "discs.png", "--landmarks", "edited.json", "-o", "again.json"]) == 0
    assert json.loads(Path("again.json").read_text()) == edited


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["flat.png"], "found 0 patterns in flat.png; patterns needs at least 4"),
        (["flat.png", "--landmarks", "flat.json"], "flat.png; patterns needs at least 4"),
        (["discs.png", "--landmarks", "flat.json"], "of an image of 64x64"),
        (["discs.png", "--landmarks", "strange.json"], "strange.json: it has unknown keys 'colour'"),
        (["discs.png", "--landmarks", "none.json"], "none.json does not exist"),
        (["discs.png", "--threshold", "0.5"], "give --landmarks too"),
        (["discs.png", "--threshold", "-1", "--landmarks", "one.json"], "no number above 0"),
        (["discs.png", "-o", "one.json"], "one.json exists"),
        (["discs.png", "-o", "one.txt"], "ending"),
        (["none.png"], "none.png does not exist"),
    ],
)
def test_what_cannot_be_done_is_refused(refused: Callable[..., str], arguments: list[str], says: str) -> None:
    assert says in refused("patterns", *arguments)


def test_a_folder_takes_the_file_by_its_usual_name(folder: Path) -> None:
    Path("made").mkdir()
    assert main(["patterns", "discs.png", "-o", "made/"]) == 0
    assert Path("made/discs_patterns.json").is_file()
