"""Programs on top of the engine: images from exemplars, files, and the command line."""

import os
from typing import TYPE_CHECKING

from synth.lazy import lazy

# threads that wait for work would otherwise spin: a quarter of all cpu seconds of a small synthesis
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

if TYPE_CHECKING:
    from kwatra.base import InputError
    from synth.io.flows import Recording, field_of, read_flow, write_flow
    from synth.io.images import Picture, read_image, write_image
    from synth.io.kinds import Kind
    from synth.metamorphosis.door import Metamorphosis, morph
    from synth.metamorphosis.patches.door import Interpolated, interpolate
    from synth.texture.filling import fill
    from synth.texture.images import synthesize
    from synth.texture.synthesis import Synthesis
    from synth.texture.tiling import tile

__all__ = [
    "InputError",
    "Interpolated",
    "Kind",
    "Metamorphosis",
    "Picture",
    "Recording",
    "Synthesis",
    "field_of",
    "fill",
    "interpolate",
    "morph",
    "read_flow",
    "read_image",
    "synthesize",
    "tile",
    "write_flow",
    "write_image",
]

__getattr__, __dir__ = lazy(
    __name__,
    {
        "InputError": "kwatra.base",
        "Interpolated": "synth.metamorphosis.patches.door",
        "Kind": "synth.io.kinds",
        "Metamorphosis": "synth.metamorphosis.door",
        "Picture": "synth.io.images",
        "Recording": "synth.io.flows",
        "Synthesis": "synth.texture.synthesis",
        "field_of": "synth.io.flows",
        "fill": "synth.texture.filling",
        "interpolate": "synth.metamorphosis.patches.door",
        "morph": "synth.metamorphosis.door",
        "read_flow": "synth.io.flows",
        "read_image": "synth.io.images",
        "synthesize": "synth.texture.images",
        "tile": "synth.texture.tiling",
        "write_flow": "synth.io.flows",
        "write_image": "synth.io.images",
    },
)
