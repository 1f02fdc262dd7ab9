"""How worn texture is renewed, and presets of it."""

from dataclasses import dataclass, replace

from kwatra.base import InputError


@dataclass(frozen=True)
class Renewing:
    """How texture is renewed.

    flow_weight: lambda, what a change costs against the motion. seam: what disagreement along a seam costs.
    tolerance: wear that is left alone. stiffness: how much copies resist being turned and stretched, in px^2; 0: not at
    all. area: what wear has where a copy shows more or less of the exemplar than its own area. tones: what parts as
    bright as others shown too often cost. usage: what much-used parts of the exemplar cost. inertia: how much the frame
    before, carried along, counts in a frame's colors against its copies' 1 where they are alike; of videos, after how
    many frames as much of what was replaced is left as their own texture keeps from one to the next; 0: nothing.
    shades: in [0, 1), of videos, how much of what the frame before is brighter or darker than the copies, over some px
    around, lasts. feather: of videos, over how many px from a seam the copy beyond it is seen; 0: none. aging: what a
    video's texture costs that cannot live on; what soon cannot, a part of it. blocks: at most so many a frame, besides
    those that new texture needs. block: their size, or that of two elements that are apart and not drawn whole. window,
    step: the windows whose energy is measured, and their distance. interpolation: see `flow.warp`. Of elements that are
    drawn whole less is renewed than is asked for (`seldom`).
    inertia was tuned on made stones, radishes, nuts and bricks in a pair of vortices: half as much flickers more by
    .004, and of sharpness this loses .02 to fast frames.
    Energies are in variances of the exemplar, sizes in px. flow_weight and blocks were tuned on nuts and bricks that
    turn by 2 px a frame. Half and twice as much was tried (see `flow.animation`) of seam (.204, .208), tolerance (.198,
    .197), stiffness (.222, .197), area (.206, .205), tones (.206, .195, renewing twice as much) and usage (.199, .212),
    and 32 and 64 px of block (.218, .207).
    """

    flow_weight: float = 0.05
    seam: float = 1.2
    tolerance: float = 0.06
    stiffness: float = 30.0
    area: float = 0.5
    tones: float = 1.0
    usage: float = 0.3
    inertia: float = 1.5
    shades: float = 0.0
    feather: int = 0
    aging: float = 0.3
    blocks: int = 14
    block: int = 48
    window: int = 24
    step: int = 6
    interpolation: str = "lanczos"

    def __post_init__(self) -> None:
        costs = self.flow_weight, self.seam, self.tolerance, self.stiffness, self.area, self.tones, self.usage
        weights = *costs, self.inertia, self.shades, self.feather, self.aging, self.blocks
        if not all(weight >= 0 for weight in weights):  # nor may one be NaN
            raise InputError(f"{self} has a weight or number of blocks that is not 0 or more; give such")
        if self.shades >= 1:
            raise InputError(f"{self} keeps all shades, for ever; give less than 1")
        if min(self.block, self.window, self.step) < 2:
            raise InputError(f"{self} has a size below 2 px; give at least 2")


PRESETS = {
    "fast": Renewing(blocks=3, window=24, step=24, interpolation="bicubic"),
    "default": Renewing(),
    "best": Renewing(blocks=60, step=4),
}
"""How much work to spend on a frame of a texture from pictures.

Fast was tuned on bricks, nuts, radishes and made stones under a rotation and a pair of vortices: with 6 blocks they
score .164 and flicker by .082, with 4 .169 and .074, with 3 .168 and .066, at .84 of the cost with 6."""


def _for_videos(preset: Renewing, blocks: int) -> Renewing:
    return replace(preset, tolerance=0.4, tones=1.2, usage=0.15, inertia=0.25, shades=0.8, feather=11, blocks=blocks)


VIDEO_PRESETS = {
    "fast": _for_videos(PRESETS["fast"], 5),
    "default": _for_videos(PRESETS["default"], 8),
    "best": _for_videos(PRESETS["best"], 16),
}
"""The same for videos, whose texture is renewed all the time, since they end. Tuned on a fountain, a waterfall and
a plume of smoke that move by 2 px a frame; feather by looking at the smoke and a flame, of which 7 px leave squares;
tones on the fountain, of which .81 of the sharpness is left over 40 frames with .6, .88 with 1.2 and more with 2, with
which dark drops come to lie in bright water."""


def seldom(renewing: Renewing) -> Renewing:
    """The same for pictures whose elements are drawn whole in every frame (`kwatra.pieces.redrawn`): less is renewed.

    They are bent as others come near, and lie as they have moved, which is no wear. Of stones, coins, tiles and mosaics
    of 20 and 32 px in a pair of vortices .069 are cut or swollen at frame 150 with a tolerance of .3, .093 with .5 and
    .17 with 1; with 6 blocks .062, at two thirds of the time, and motion of stones and coins of 20 px is off by .13
    .18 px, by .13 .20 and more with 14.
    """
    return replace(renewing, tolerance=max(renewing.tolerance, 0.3), blocks=min(renewing.blocks, 6))
