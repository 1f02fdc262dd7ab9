"""Synthesis: a new picture of any size from pictures of one texture, or a new video from videos."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from torch import Tensor

from kwatra import InputError, Progress, Sum, TermLike
from synth.texture.asked import Asked
from synth.texture.form import Image
from synth.texture.patchwork import Patchwork
from synth.texture.synthesis import Synthesis, joined
from synth.texture.work import Work


def synthesize(
    exemplar: Image | Sequence[Image],
    size: Sequence[int] | None = None,
    *,
    preset: str = "default",
    seed: int = 0,
    tile: bool = False,
    loop: bool = False,
    stay: float | None = None,
    start: Image | None = None,
    levels: str | Sequence[tuple[int, int]] | None = None,
    mirror: bool = False,
    rotate: Sequence[float] = (),
    scale: Sequence[float] = (),
    terms: TermLike | Sum | Sequence[TermLike | Sum] = (),
    mask: Tensor | np.ndarray | None = None,
    guide: tuple[Any, Any] | list[tuple[Any, Any]] | None = None,
    guide_weight: float | Sequence[float] = 1.0,
    exemplar_mask: Tensor | np.ndarray | Sequence[Tensor | np.ndarray] | None = None,
    device: str = "cpu",
    callback: Callable[[Progress], None] | None = None,
) -> Synthesis[Image]:
    """A picture of `size` (height, width), or a video of (frames, height, width), that looks like the exemplar.

    exemplar: one or several images of a texture: tensors (C, H, W), or arrays (H, W) or (H, W, C), of any number of
    channels, floating point in any range or integer; or videos (C, T, H, W), or arrays (T, H, W, C). The result is of
    the same kind and range. preset: "fast", "default" or "best"; small stills begin with the best of 1, 6 or 12
    layouts, and "best" goes on from there. tile: the output repeats seamlessly in both directions. loop: of a video,
    the last frame leads into the first. stay: how strongly what belongs somewhere in the frame stays there (see
    `kwatra.Stay`); None: a video does where its statistics depend on the place. start: an image of the output's size to
    improve, instead of beginning anew. levels: (factor, window width) pairs, coarse to fine, or "thesis". mirror,
    rotate (degrees, counterclockwise), scale (factors): also copy from such variants of the exemplar. terms: control
    terms; their values are those of the exemplar scaled so that its least value is 0 and its largest is 1. mask:
    boolean, of the output's size, True where texture belongs. guide: a map of the exemplar (one for each) and one of
    the output, of one kind and any number of channels: where the output's has a value, texture goes that has a like one
    in the exemplar; `size` may be left out, it is the output map's. Labels that fill rectangles of the exemplars, or
    whole ones (`synth.texture.labeling`), name textures: each is then made by itself and joined to the others, unless
    more is asked of the output, or the exemplar has a mask. guide_weight: what the guide counts beside the colors; 0.1
    to 0.3 suits maps that vary smoothly. Several guides are a list, and may have a weight each.
    exemplar_mask: boolean, of the exemplar's size, True where it may be copied from; of several exemplars one for each.
    Of a still light that falls unevenly is taken out of the exemplar (see `synth.texture.illumination`), unless terms,
    a guide other than labels, a start or stay are given, which may mean it; and seams are eased where nothing steers
    and no levels are given (see `synth.texture.easing`).
    callback: told of each iteration, by one thread at a time, but not always the same one. Same seed, same bits, for
    any number of threads.

    A long video of which nothing but its texture is asked is made in stretches, see `stretches`. Raises InputError for
    what cannot be used.
    """
    steered = bool(terms) or bool(stay) or any(one is not None for one in (mask, start, levels, exemplar_mask))
    asked: Asked[Image] = Asked.of(exemplar, size, guide, guide_weight)
    patchwork = None if steered else Patchwork.of(asked)
    if patchwork is not None:
        texture = {"preset": preset, "loop": loop, "mirror": mirror, "rotate": rotate, "scale": scale, "device": device}
        return patchwork.made(seed, callback, tile, **texture)
    work = Work.of(
        asked, preset=preset, tile=tile, loop=loop, stay=stay, start=start, levels=levels, mirror=mirror,
        rotate=rotate, scale=scale, terms=terms, mask=mask, exemplar_mask=exemplar_mask, device=device,
    )  # fmt: skip
    del asked  # and the memory of its pictures with it
    parts = work.stretches()
    if len(parts) == 1:
        return work.made(work.optimized(parts[0], None, seed, callback), parts[0])
    return joined(list(work.run(parts, seed, callback)))


def stretches(
    exemplar: Image | Sequence[Image],
    size: Sequence[int],
    *,
    seed: int = 0,
    done: int = 0,
    shown: Callable[[int, int], Image] | None = None,
    callback: Callable[[Progress], None] | None = None,
    guide: tuple[Any, Any] | list[tuple[Any, Any]] | None = None,
    guide_weight: float | Sequence[float] = 1.0,
    **options: Any,
) -> Iterator[Synthesis[Image]]:
    """A video of `size` (frames, height, width), made and given stretch by stretch in order: any length, one's memory.

    A stretch overlaps the one before it by `HELD` frames, which it holds as they are; a loop's last one leads to the
    first frames likewise. options: those of `synthesize`; where more than texture is asked for (terms, mask, start,
    guide) there is one stretch, the whole video. done: so many frames were made by a former run; those that follow are
    given, the same bits as without the break. shown: gives the frames from a to b - 1, all of them given before, as
    `shown(a, b)`: where they are kept. Raises InputError as `synthesize`.
    """
    work: Work[Image] = Work.of(Asked.of(exemplar, size, guide, guide_weight), **options)
    if len(work.size) == 2:
        raise InputError("stretches are of videos but the exemplar is an image; use synthesize")
    if done and shown is None:
        raise InputError(f"{done} frames are done but nothing shows them; give `shown`")
    return work.run(work.stretches(), seed, callback, done, shown)
