"""Folders of frames keep all of a sequence's state, so that it goes on as if it had not been left."""

from dataclasses import fields
from pathlib import Path

import pytest
import torch

from flow.animation.state import State
from kwatra import InputError
from synth.io.frames import FramesFolder
from synth.io.kinds import Kind


def test_all_of_a_state_is_kept(tmp_path: Path) -> None:
    names = [field.name for field in fields(State) if field.name != "number"]
    tensors = {name: torch.full((3, 4, 5), float(at)) for at, name in enumerate(names)}
    folder = FramesFolder(tmp_path / "frames", Kind("uint8", ("R", "G", "B")), {})
    with folder.alone():
        folder.begin(more=False)
    folder.add(torch.zeros(3, 4, 5), State(0, **tensors))
    state = folder.state()
    assert state is not None
    assert state.number == 0
    for name, tensor in tensors.items():
        assert torch.equal(getattr(state, name), tensor), name


def test_a_folder_belongs_to_one_run_at_a_time(tmp_path: Path) -> None:
    one, other = (FramesFolder(tmp_path / "frames", Kind("uint8", ("Y",)), {"seed": seed}) for seed in "12")
    with one.alone():
        one.begin(more=False)
        one.add(torch.zeros(1, 4, 5), State(0, *(torch.zeros(3, 4, 5) for _ in range(3))))
        with pytest.raises(InputError, match="is being written by another run"), other.alone():
            pass
    with other.alone(), pytest.raises(InputError, match="holds frames"):  # which came since it was looked at
        other.begin(more=False)
    with other.alone():
        other.begin(more=True)
    assert other.count() == 0
