"""`python -m kwatra` runs the program installed under the name kwatra; the engine itself has no command line."""

import sys
from importlib.metadata import entry_points

scripts = list(entry_points(group="console_scripts", name="kwatra"))
sys.exit(scripts[0].load()() if scripts else "kwatra: error: its command line is not installed; use pip install kwatra")
