"""`kwatra score` of gray clips in files that hold colors."""

import json

import torch

from synth import Kind, write_image
from synth.cli import main
from synth.io.videos import write_video


def test_a_gray_clip_is_scored_as_the_file_that_was_made_of_it(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    noise = torch.rand(1, 6, 32, 32, generator=torch.Generator().manual_seed(0))
    clip = torch.nn.functional.avg_pool3d(noise, (1, 5, 5), 1, (0, 2, 2))
    write_video("gray", clip, 10.0, Kind("uint8", ("Y",)))
    write_video("gray.mp4", clip.expand(3, -1, -1, -1), 10.0)
    assert main(["score", "gray", "gray.mp4", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[0]["overall"] < 0.2
    assert main(["score", "gray.mp4", "gray", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[0]["overall"] < 0.2
    write_video("red.gif", torch.cat([clip, 0 * clip, 0 * clip]), 10.0)
    assert main(["score", "gray", "red.gif"]) == 2
    assert "an output has its exemplar's channels" in capsys.readouterr().err


def test_what_is_too_small_is_named(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name, side in (("brick.png", 16), ("crumb.png", 6)):
        write_image(name, torch.rand(1, side, side), Kind("uint8", ("Y",)))
    assert main(["score", "brick.png", "brick.png", "crumb.png"]) == 2
    assert "crumb.png is 6x6; at least 7x7 pixels are measured" in capsys.readouterr().err
