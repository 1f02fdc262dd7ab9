"""Programs on top of the engine: images from exemplars, files, and the command line.

The public names are loaded on first use, so that ``kwatra --help`` need not wait for torch.
"""

import os
from typing import TYPE_CHECKING, Any

# threads that wait for work would otherwise spin: a quarter of all cpu seconds of a small synthesis
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

if TYPE_CHECKING:
    from synth.files import Picture, read_image, write_image
    from synth.filling import fill
    from synth.formats import Kind
    from synth.images import Synthesis, synthesize

__all__ = ["Kind", "Picture", "Synthesis", "fill", "read_image", "synthesize", "write_image"]

_HOMES = {
    "Kind": "synth.formats",
    "Picture": "synth.files",
    "Synthesis": "synth.images",
    "fill": "synth.filling",
    "read_image": "synth.files",
    "synthesize": "synth.images",
    "write_image": "synth.files",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'synth' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
