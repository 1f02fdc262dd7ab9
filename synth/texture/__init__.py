"""Images from exemplars: synthesis, filling, guidance, the maps that go with them."""

from typing import TYPE_CHECKING

from synth.lazy import lazy

if TYPE_CHECKING:
    from synth.texture.filling import fill
    from synth.texture.images import stretches, synthesize
    from synth.texture.labeling import labels
    from synth.texture.maps import (
        Map,
        check_source_output,
        guide_files,
        map_writer,
        read_guide,
        read_map,
        read_source,
        rearranged,
        source_writer,
    )
    from synth.texture.periods import whole_size
    from synth.texture.synthesis import Synthesis, taken
    from synth.texture.tiling import tile
    from synth.texture.toning import tones
    from synth.texture.work import PRESETS

__all__ = [
    "PRESETS",
    "Map",
    "Synthesis",
    "check_source_output",
    "fill",
    "guide_files",
    "labels",
    "map_writer",
    "read_guide",
    "read_map",
    "read_source",
    "rearranged",
    "source_writer",
    "stretches",
    "synthesize",
    "taken",
    "tile",
    "tones",
    "whole_size",
]

__getattr__, __dir__ = lazy(
    __name__,
    {
        "PRESETS": "synth.texture.work",
        "Map": "synth.texture.maps",
        "Synthesis": "synth.texture.synthesis",
        "check_source_output": "synth.texture.maps",
        "fill": "synth.texture.filling",
        "guide_files": "synth.texture.maps",
        "labels": "synth.texture.labeling",
        "map_writer": "synth.texture.maps",
        "read_guide": "synth.texture.maps",
        "read_map": "synth.texture.maps",
        "read_source": "synth.texture.maps",
        "rearranged": "synth.texture.maps",
        "source_writer": "synth.texture.maps",
        "stretches": "synth.texture.images",
        "synthesize": "synth.texture.images",
        "taken": "synth.texture.synthesis",
        "tile": "synth.texture.tiling",
        "tones": "synth.texture.toning",
        "whole_size": "synth.texture.periods",
    },
)
