"""Programs on top of the engine: images from exemplars, files, and the command line.

The public names are loaded on first use, so that ``kwatra --help`` need not wait for torch.
"""

import os
from typing import TYPE_CHECKING, Any

# threads that wait for work would otherwise spin: a quarter of all cpu seconds of a small synthesis
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

if TYPE_CHECKING:
    from synth.io.flows import Recording, field_of, read_flow, write_flow
    from synth.io.image_formats import Kind
    from synth.io.images import Picture, read_image, write_image
    from synth.morph.door import Metamorphosis, morph
    from synth.texture.filling import fill
    from synth.texture.images import Synthesis, synthesize

__all__ = [
    "Kind",
    "Metamorphosis",
    "Picture",
    "Recording",
    "Synthesis",
    "field_of",
    "fill",
    "morph",
    "read_flow",
    "read_image",
    "synthesize",
    "write_flow",
    "write_image",
]

_HOMES = {
    "Kind": "synth.io.image_formats",
    "Metamorphosis": "synth.morph.door",
    "Picture": "synth.io.images",
    "Recording": "synth.io.flows",
    "Synthesis": "synth.texture.images",
    "field_of": "synth.io.flows",
    "fill": "synth.texture.filling",
    "morph": "synth.morph.door",
    "read_flow": "synth.io.flows",
    "read_image": "synth.io.images",
    "synthesize": "synth.texture.images",
    "write_flow": "synth.io.flows",
    "write_image": "synth.io.images",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'synth' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
