"""Video by graph-cut quilting (thesis section 3.5): transitions, random offsets in time, offsets in space and time.

    transition  the clip joined to itself where two of its frames are most alike, along a seam surface in a window of
                frames around them; endless, and every frame outside the window is a frame of the clip
    time        the whole clip laid down again and again, displaced in time only; less repetitive than a loop
    spacetime   the clip laid down displaced in space and time; for motion like water and smoke, and for larger frames

Any of them loops: `time` and `spacetime` hold the first k and last k frames of the work to the same k frames, and drop
the first k (3.5 D).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

from torch import Tensor

from kwatra.base import InputError, floats_of, is_whole, whole_sizes
from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Mosaic
from kwatra.pieces.sheet import Patch, Sheet
from synth.quilting.displaced import displaced, lasting_region
from synth.quilting.enlarge import composed, enlarged
from synth.quilting.growth import Report
from synth.quilting.loops import adopt
from synth.quilting.synthesis import (
    Quilt,
    QuiltSettings,
    check_exemplar,
    new_placer,
    new_sheet,
    result_of,
    run,
    sources_of,
)
from synth.quilting.transition import MOST_PIXELS, seam_transition

DRIFT = 8
"""Patches of a scene are moved in the frame by at most one part in so many of its sides: motion and light differ from
place to place."""

MODES = ("transition", "time", "spacetime")


def quilt_video(
    clip: Tensor,
    frames: int | None = None,
    size: Sequence[int] | None = None,
    *,
    mode: str = "transition",
    loop: bool = False,
    hold: int | None = None,
    settings: QuiltSettings | None = None,
    report: Report = lambda what, part: None,
) -> Quilt:
    """A new video from a clip (C, T, H, W).

    `frames`: its length; twice the clip's by default, and one period of a transition. `size`: (H, W), the clip's by
    default; other sizes need mode "spacetime": the frames are enlarged first, by copies that always match as a whole,
    and a loop of no given length is then a transition. `loop`: the frame after the last is the first. `hold`: the k
    above; by default 10, or half of a shorter clip.
    `settings`: as for `quilt`; by default sub-patch matching for "spacetime" and random placement for "time".
    Raises InputError for a clip of one frame, `hold` larger than the clip, a size or length that the mode cannot make.
    """
    clip = floats_of(clip).cpu()
    check_exemplar(clip)
    size = tuple(clip.shape[-2:]) if size is None else whole_sizes(size, 2, "the size")
    if hold is None and clip.ndim == 4:
        hold = min(10, clip.shape[1] // 2)
    _check(clip, frames, size, mode, loop, hold)
    frames = None if frames is None else int(frames)
    settings = settings or default_settings(mode)
    if size != tuple(clip.shape[-2:]):
        return _of_size(clip, size, frames, mode, loop, hold, settings, report)
    if mode == "transition":
        return seam_transition(clip, frames, loop, settings, report)
    length = 2 * clip.shape[1] if frames is None else frames
    held = hold if loop and hold is not None else 0

    def begun(source: Tensor) -> Sheet[Mosaic]:
        sheet = new_sheet(sources_of(source, settings), (length + held, *source.shape[2:]), settings)
        if held:
            _hold_ends(sheet, held)
        return sheet

    if mode == "time":
        sheet, history, stopped = displaced(clip, begun, settings, report)
    else:
        sheet, history, stopped = _moved(clip, begun, bool(held), settings, report)
    return result_of(sheet, settings, history, stopped, first=held)


def _of_size(
    clip: Tensor,
    size: tuple[int, ...],
    frames: int | None,
    mode: str,
    loop: bool,
    hold: int | None,
    settings: QuiltSettings,
    report: Report,
) -> Quilt:
    """The video of a clip whose frames are enlarged first."""
    larger = enlarged(clip, size, settings, report)
    way = "transition" if loop and frames is None else mode
    frames = 2 * clip.shape[1] if way == mode and frames is None else frames
    rest = dataclasses.replace(settings, rotate=(), mirror=False, scale=(), perspective=False)
    outer = quilt_video(larger.image, frames, mode=way, loop=loop, hold=hold, settings=rest, report=report)
    return composed(outer, larger)


def _moved(
    clip: Tensor, begun: Callable[[Tensor], Sheet[Mosaic]], held: bool, settings: QuiltSettings, report: Report
) -> tuple[Sheet[Mosaic], list[int], str]:
    """Sewn of patches displaced in space and time; returns as `displaced` does.

    Whether a clip is a scene, whose patches fit only near their place, is seen when it is sewn: it is done with patches
    that stay there and with any, and the cheaper seams are kept.
    """
    region = lasting_region(clip.shape[1:], settings.region)
    if settings.seconds is not None:
        settings = dataclasses.replace(settings, seconds=settings.seconds / 2)

    def sewn(near: bool) -> tuple[Sheet[Mosaic], list[int], str]:
        sheet = begun(clip)
        if not held:
            _lay_in_place(sheet, clip.shape[1])
        drift = (sheet.shape[0], *(side // DRIFT for side in clip.shape[2:])) if near else None
        placer = new_placer(sheet, settings, region, reach=2.0, drift=drift)
        return sheet, *run(sheet, placer, settings, report)

    return min((sewn(near) for near in (True, False)), key=lambda trial: trial[0].total)


def default_settings(mode: str) -> QuiltSettings:
    """What suits a mode: motion is matched locally, and time-only offsets are drawn at random, as in the thesis.

    What moves hides a seam (equation 5), and what remains of it is feathered by a pixel and a few frames: a seam in
    time is seen as a flash, not as a line. Of patches moved in space too, those over the busy middle of a clip can be
    laid in more ways than those at its borders, so that motion would grow unless using a part again is priced.
    """
    common = QuiltSettings(normalized=True, grid=1, evenness=0.0, refine=60, patience=15, feather=1.0)
    if mode == "spacetime":
        return dataclasses.replace(common, placement="sub", evenness=1.0)
    return dataclasses.replace(common, placement="random" if mode == "time" else "sub")


def _check(clip: Tensor, frames: int | None, size: tuple[int, ...], mode: str, loop: bool, hold: int | None) -> None:
    if clip.ndim != 4:
        raise InputError(f"the clip has shape {tuple(clip.shape)} but must be (C, T, H, W)")
    if mode not in MODES:
        raise InputError(f"mode is {mode!r} but must be one of {', '.join(MODES)}")
    if size != tuple(clip.shape[-2:]) and mode != "spacetime":
        raise InputError(
            f"size is {size[1]}x{size[0]} but mode {mode} keeps the clip's {clip.shape[3]}x{clip.shape[2]}; "
            "for another size use mode spacetime"
        )
    if frames is not None and not is_whole(frames, 2):
        raise InputError(f"frames is {frames} but a video needs a whole number, at least 2")
    if not loop or mode == "transition":
        return
    assert hold is not None
    if not 1 <= hold <= clip.shape[1]:
        raise InputError(f"hold is {hold} but the clip has {clip.shape[1]} frames; hold between 1 and that many")
    if frames is not None and frames <= hold:
        raise InputError(
            f"frames is {frames} but a loop that holds {hold} needs more than that; hold fewer or make more"
        )


def _lay_in_place(sheet: Sheet[Mosaic], count: int) -> None:
    """Begin in the middle with the clip of `count` frames as it is, so that what grows from it fits the scene."""
    length, *frame = sheet.shape
    first, some = (length - min(count, length)) // 2, max(MOST_PIXELS // math.prod(frame), 1)
    for start in range(first, first + min(count, length), some):
        extent = min(some, first + min(count, length) - start)
        sheet.lay(Patch(0, (first, 0, 0), Box((start, 0, 0), (extent, *frame))))


def _hold_ends(sheet: Sheet[Mosaic], hold: int) -> None:
    """Lay the same `hold` frames at both ends of the sheet and fix them."""
    slab = Sheet(sheet.sources, (hold, *sheet.shape[1:]), (False, *sheet.periodic[1:]), sheet.cost)
    # From the middle of the clip, so that there is something to go on with on either side.
    middle = (sheet.sources.shapes[0][0] - hold) // 2
    slab.lay(Patch(0, (-middle, 0, 0), Box((0, 0, 0), slab.shape)))
    adopt(sheet, slab, 0)
    adopt(sheet, slab, sheet.shape[0] - hold)
