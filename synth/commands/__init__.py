"""The command line: one file per command, with its arguments (`add`) and its run, and what they share.

The files import nothing that takes long; what they need loads when a command runs, so that `--help` answers at once.
"""

NAMES = ("synth", "fill", "tile", "score", "flow", "animate", "quilt", "merge", "morph", "patterns", "run")
"""The commands, each a module of this package, in the order in which `--help` lists them."""
