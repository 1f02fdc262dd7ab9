"""Folders of frames keep all of a sequence's state, so that it goes on as if it had not been left."""

from dataclasses import fields
from pathlib import Path

import torch

from flow.animation.state import State
from synth.io.frames import FramesFolder
from synth.io.kinds import Kind


def test_all_of_a_state_is_kept(tmp_path: Path) -> None:
    names = [field.name for field in fields(State) if field.name != "number"]
    tensors = {name: torch.full((3, 4, 5), float(at)) for at, name in enumerate(names)}
    folder = FramesFolder(tmp_path / "frames", Kind("uint8", ("R", "G", "B")), {})
    folder.begin()
    folder.add(torch.zeros(3, 4, 5), State(0, **tensors))
    state = folder.state()
    assert state is not None
    assert state.number == 0
    for name, tensor in tensors.items():
        assert torch.equal(getattr(state, name), tensor), name
