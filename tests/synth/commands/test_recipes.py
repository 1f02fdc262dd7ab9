"""Recipes: a result made again by its file, and what is said when it cannot be."""

import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch

from synth import Kind, write_image
from synth.cli import main
from synth.commands.recipes import _quoted

RGB = Kind("uint8", ("R", "G", "B"))
SYNTH = ["synth", "brick ü.png", "--preset", "fast", "--size", "40x40", "-o", "out.png", "--also", "n=n.png"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    generator = torch.Generator().manual_seed(0)
    for name in ("brick ü.png", "n.png"):
        write_image(name, torch.rand(3, 24, 24, generator=generator), RGB)
    return tmp_path


def test_a_result_is_made_again_elsewhere_by_its_recipe(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*SYNTH, "--save-recipe", "r.toml"]) == 0
    assert capsys.readouterr().out.endswith("\nits recipe is r.toml\n")
    table = tomllib.loads(Path("r.toml").read_text(encoding="utf-8"))
    assert table["command"] == [*SYNTH, "--seed", "0"]
    assert set(table["inputs"]) == {"brick ü.png", "n.png"}
    assert set(table["outputs"]) == {"out.png", "out_n.png"}
    assert set(table["versions"]) >= {"kwatra", "torch"}
    made = {name: Path(name).read_bytes() for name in ("out.png", "out_n.png")}
    for name in made:
        Path(name).unlink()
    Path("elsewhere").mkdir()
    monkeypatch.chdir("elsewhere")
    assert main(["run", "../r.toml"]) == 0
    assert capsys.readouterr().out.endswith("\nthe same bits as then\n")
    assert {name: Path(f"../{name}").read_bytes() for name in made} == made
    assert main(["run", "../r.toml", "-o", "again.png"]) == 0
    assert Path("again.png").read_bytes() == made["out.png"]
    assert Path.cwd() == folder / "elsewhere"


def test_outputs_that_are_there_are_no_inputs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*SYNTH, "--map", "m.npy"]) == 0
    assert main([*SYNTH, "--map", "m.npy", "--overwrite", "--save-recipe=r.toml", "--seed=3"]) == 0
    table = tomllib.loads(Path("r.toml").read_text(encoding="utf-8"))
    assert set(table["inputs"]) == {"brick ü.png", "n.png"}
    assert table["command"][-1] == "--seed=3"
    Path("out.png").write_bytes(b"else")
    capsys.readouterr()
    assert main(["run", "r.toml", "--overwrite"]) == 0
    assert "the same bits as then" in capsys.readouterr().out


def test_files_are_replaced_only_where_the_run_itself_is_allowed_to(folder: Path, refused: Callable[..., str]) -> None:
    assert main([*SYNTH, "--overwrite", "--save-recipe", "r.toml"]) == 0
    Path("precious.png").write_bytes(b"else")
    assert "out.png exists" in refused("run", "r.toml")
    assert "precious.png exists" in refused("run", "r.toml", "-o", "precious.png")
    assert Path("precious.png").read_bytes() == b"else"


def test_files_that_changed_or_went_are_told_of(folder: Path, refused: Callable[..., str]) -> None:
    assert main([*SYNTH, "--save-recipe", "r.toml"]) == 0
    assert "out.png exists" in refused("run", "r.toml")
    write_image("n.png", torch.zeros(3, 24, 24), RGB, overwrite=True)
    assert "n.png changed since r.toml was saved; to run it all the same give --changed" in refused("run", "r.toml")
    assert main(["run", "r.toml", "--changed", "--overwrite"]) == 0
    Path("n.png").unlink()
    assert "n.png, which r.toml was saved with, is not in" in refused("run", "r.toml", "--overwrite")


def test_other_versions_and_other_bits_are_told_of(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*SYNTH, "--save-recipe", "r.toml"]) == 0
    text = Path("r.toml").read_text(encoding="utf-8")
    version = tomllib.loads(text)["versions"]["torch"]
    text = text.replace(f'"torch" = "{version}"', '"torch" = "0.1"')
    output = tomllib.loads(text)["outputs"]["out.png"]
    Path("old.toml").write_text(text.replace(output, "0" * 64), encoding="utf-8")
    capsys.readouterr()
    assert main(["run", "old.toml", "--overwrite"]) == 0
    out, err = capsys.readouterr()
    assert f"other versions may make other bits: torch 0.1 then, {version} now" in err
    assert out.endswith("\nnot the same bits as then\n")


def test_what_is_no_recipe_is_refused(folder: Path, refused: Callable[..., str]) -> None:
    for name, text in {
        "a.toml": "command = [1]",
        "b.toml": 'format = "kwatra recipe"\ncommand = ["run", "b.toml"]\n',
        "c.toml": 'format = "kwatra recipe"\ncommand = ["synth"]\nfolder = "none"\n',
        "d.toml": "not toml",
        "e.toml": 'format = "kwatra recipe"\ncommand = ["synth"]\ninputs = [3]\n',
    }.items():
        Path(name).write_text(text)
    assert "a.toml is no recipe" in refused("run", "a.toml")
    assert "b.toml runs a recipe itself" in refused("run", "b.toml")
    assert "does not exist; make it first" in refused("run", "c.toml")
    assert "d.toml cannot be read as TOML" in refused("run", "d.toml")
    assert "e.toml is no recipe" in refused("run", "e.toml")
    assert "f.toml does not exist" in refused("run", "f.toml")
    Path("g.toml").mkdir()
    assert "g.toml is a folder; name a recipe" in refused("run", "g.toml")
    assert "end it with .toml" in refused(*SYNTH, "--save-recipe", "r.txt")
    assert "a.toml exists" in refused(*SYNTH, "--save-recipe", "a.toml")


def test_folders_are_inputs_too(folder: Path, refused: Callable[..., str]) -> None:
    Path("clip").mkdir()
    for number in range(3):
        write_image(f"clip/{number}.png", torch.full((3, 12, 12), number / 3), RGB)
    quilt = ["quilt", "clip", "-o", "made", "--mode", "time", "--save-recipe", "r.toml"]
    assert main(quilt) == 0
    assert main(["run", "r.toml", "--overwrite"]) == 0
    np.save("clip/more.npy", np.zeros(3))
    assert "clip changed" in refused("run", "r.toml", "--overwrite")


def test_texts_are_read_as_they_were_written() -> None:
    for text in ("brick \u00fc", "\U0001f9f1.png", 'a "b" \\ c\td\n', "\x7f\x01", ""):
        assert tomllib.loads(f"text = {_quoted(text)}")["text"] == text
