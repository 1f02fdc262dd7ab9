"""That this project's packages are those that python finds."""

from functools import cache
from importlib.util import find_spec
from pathlib import Path

NAMES = ("kwatra", "flow")


@cache
def shadowed() -> str | None:
    """A sentence where another `kwatra` or `flow` stands before ours on python's path, else None.

    In an editable install a folder of that name in the current folder is found first.
    """
    root = Path(__file__).resolve().parent.parent
    for name in NAMES:
        found = find_spec(name)
        places = [] if found is None else list(found.submodule_search_locations or [found.origin or ""])
        if [Path(place).resolve() for place in places] != [root / name]:
            return (
                f"python finds {places[0] if places else 'nothing'} as the package {name}, not {root / name}; "
                "start in another folder, or rename that one"
            )
    return None
