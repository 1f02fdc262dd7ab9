"""Graph-cut quilting of images and video, and merging along seams (Kwatra's thesis, chapter 3).

`quilt` makes images (and video as plain 3-D textures), `quilt_video` loops and longer or larger videos, `merge`
joins images; each returns a `Quilt`. Patches are laid by `kwatra.pieces`; the rooms, in the order data passes:
variants, matching, folds, borders, placement, growth, loops, blendseams, synthesis; then starts, transition, displaced,
enlarge and video, merging, draw. Names load on first use, so that the command line answers before torch is there.
"""

from typing import TYPE_CHECKING

from synth.lazy import lazy

if TYPE_CHECKING:
    from synth.quilting.draw import seams_drawn
    from synth.quilting.merging import Overlay, merge
    from synth.quilting.synthesis import Quilt, QuiltSettings, quilt
    from synth.quilting.tracing import origins, turns
    from synth.quilting.video import default_settings, quilt_video

__all__ = [
    "Overlay",
    "Quilt",
    "QuiltSettings",
    "default_settings",
    "merge",
    "origins",
    "quilt",
    "quilt_video",
    "seams_drawn",
    "turns",
]

__getattr__, __dir__ = lazy(
    __name__,
    {
        "Overlay": "synth.quilting.merging",
        "Quilt": "synth.quilting.synthesis",
        "QuiltSettings": "synth.quilting.synthesis",
        "default_settings": "synth.quilting.video",
        "merge": "synth.quilting.merging",
        "origins": "synth.quilting.tracing",
        "quilt": "synth.quilting.synthesis",
        "quilt_video": "synth.quilting.video",
        "seams_drawn": "synth.quilting.draw",
        "turns": "synth.quilting.tracing",
    },
)
