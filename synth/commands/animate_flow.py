"""The flow that `kwatra animate` is asked for: one that has a name, or a file's, which is read once."""

import argparse
import hashlib
from dataclasses import dataclass
from pathlib import Path

from flow import Field
from kwatra.base import InputError
from synth.commands.checks import refuse_unused
from synth.io.flows import FLOW_SUFFIXES, Recording, field_of, read_flow
from synth.words import counted


@dataclass(frozen=True)
class AskedFlow:
    """A flow as --flow has it; recorded: what the file holds, None where it is none."""

    text: str
    recorded: Recording | None

    @classmethod
    def read(cls, arguments: argparse.Namespace) -> "AskedFlow":
        """What the arguments ask for; InputError for a file that cannot be read, or options that a name cannot have."""
        if _is_file(arguments.flow):
            return cls(arguments.flow, read_flow(arguments.flow))
        refuse_unused(arguments, ["resample"], f"stretches a file's flow but {arguments.flow} is made for any size")
        return cls(arguments.flow, None)

    def field(self, speed: float | None, resample: bool) -> Field:
        """The field; see `synth.field_of`."""
        return field_of(self.text, speed) if self.recorded is None else self.recorded.field(speed, resample)

    @property
    def size(self) -> tuple[int, int] | None:
        """(H, W) of a file; None of what is made for any size."""
        if self.recorded is None:
            return None
        height, width = self.recorded.known.shape[-2:]
        return height, width

    @property
    def digest(self) -> str:
        """What tells this flow from others: a name, or what a file holds."""
        if self.recorded is None:
            return self.text
        told = hashlib.sha256()
        for values in (self.recorded.flow, self.recorded.known):
            told.update(values.numpy().tobytes())
        return told.hexdigest()

    def length(self, arguments: argparse.Namespace, usual: int) -> int:
        """How many frames to make: as asked, or as far as a flow in time leads, or else the usual number.

        Raises InputError for more than the flow leads to; a loop needs one that leads back.
        """
        asked: int | None = arguments.loop or arguments.frames
        flows = 1 if self.recorded is None or self.recorded.flow.ndim == 3 else len(self.recorded.flow)
        if flows == 1:
            return asked or usual
        most = flows if arguments.loop else flows + 1
        if asked is not None and asked > most:
            raise InputError(
                f"{self.text} holds {flows} flows, which lead to {counted(most, 'frame')}, but {asked} are "
                f"asked for; give --{'loop' if arguments.loop else 'frames'} {most} or less, or a longer flow"
            )
        return asked or most


def name_of(text: str) -> str:
    """What a flow is called in a file's name."""
    return Path(text).stem if _is_file(text) else text.replace(":", "")


def _is_file(text: str) -> bool:
    return Path(text).suffix.lower() in FLOW_SUFFIXES
