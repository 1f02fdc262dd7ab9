"""`python -m synth` is `kwatra`."""

from synth.cli import entry

entry()
