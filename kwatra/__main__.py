"""`python -m kwatra` runs the program installed under the name kwatra; the engine itself has no command line."""

import sys

try:
    from importlib.metadata import entry_points

    scripts = list(entry_points(group="console_scripts", name="kwatra"))
    program = scripts[0].load() if scripts else None
except KeyboardInterrupt:  # the program itself minds those that come later
    print("kwatra: interrupted, nothing was written", file=sys.stderr)
    sys.exit(130)
sys.exit("kwatra: error: its command line is not installed; use pip install kwatra" if program is None else program())
