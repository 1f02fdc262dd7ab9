"""Flow fields, steady or in time, as small values that add and scale: `2.0 * rotation() + uniform(angle=90)`.

A field gives for any time and frame size how far each pixel moves within the frame that begins then: forward, x
first, in pixels. x grows to the right and y down, so an angle of 0 degrees points right, one of 90 down.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import torch
import torch.nn.functional as F
from torch import Tensor

from flow.checks import check_flow, check_vectors
from kwatra.base import InputError, whole_sizes

Shape = tuple[int, int]


_STILL = 1e-30
"""px per frame below which a flow cannot be brought to a speed in float32."""


@dataclass(frozen=True)
class Field:
    """A flow field made from any function `at(t, shape)` that returns (2, H, W) for a frame of `shape` = (H, W).

    steady: it is the same at all times. A field of one's own is `Field(function, steady)`.
    """

    at: Callable[[float, Shape], Tensor]
    steady: bool = False

    def __call__(self, t: float, shape: Shape) -> Tensor:
        """The flow (2, H, W) float32 from time t (in frames) to t + 1, of a frame of shape (height, width).

        Raises InputError if the field has another size, has vectors that are not finite, or leaves the frame.
        """
        flow = self.at(t, shape).to(torch.float32, copy=True)
        check_flow(flow, shape)
        return flow

    def __add__(self, other: "Field") -> "Field":
        return Field(lambda t, shape: self.at(t, shape) + other.at(t, shape), self.steady and other.steady)

    def __mul__(self, factor: float) -> "Field":
        return Field(lambda t, shape: factor * self.at(t, shape), self.steady)

    __rmul__ = __mul__


def at_speed(formula: Callable[[float, Shape], Tensor], speed: float, steady: bool = True) -> Field:
    """The field of a formula for the flow's directions, scaled at all times so that the fastest pixel of the frame
    moves `speed` px per frame; a negative speed turns it around, and what moves nowhere stays so.
    """  # fmt: skip
    _check_speed(speed)

    def at(t: float, shape: Shape) -> Tensor:
        flow = formula(t, shape)
        fastest = flow.norm(dim=0).max()
        return flow * (speed / fastest if bool(fastest > 0) else 0.0)

    return Field(at, steady)


def sampled(flows: Tensor, resample: bool = False, speed: float | None = None) -> Field:
    """The field of a flow (2, H, W), or of flows (T, 2, H, W), flow i leading from frame i to frame i + 1.

    Between whole times flows are interpolated linearly; before the first and after the last they hold still, so a
    sequence ends in a steady motion. resample: stretch it over frames of another size, vectors with it; else such
    frames are refused. speed: scale the whole sequence, whatever its unit, so that its fastest pixel moves that far per
    frame.

    Raises InputError for another shape, no flow at all, or vectors that are NaN or infinite.
    """
    flows = flows[None] if flows.ndim == 3 else flows
    if flows.ndim != 4 or flows.shape[1] != 2 or 0 in flows.shape:
        raise InputError(f"flows have shape {tuple(flows.shape)}; give (2, H, W), or (T, 2, H, W) in time")
    for flow in flows:
        check_flow(flow) if speed is None else check_vectors(flow)
    if speed is not None:
        _check_speed(speed)
        if not bool(flows.any()):
            raise InputError(f"a flow is zero everywhere and cannot be brought to a speed of {speed:g}; leave that out")

    def fitted(flow: Tensor, shape: Shape) -> Tensor:
        return resampled(flow, shape) if resample else flow

    @lru_cache(1)
    def factor(shape: Shape) -> float:
        if speed is None:
            return 1.0
        fastest = max(float(fitted(flow, shape).norm(dim=0).max()) for flow in flows)
        if fastest < _STILL:
            raise InputError(f"a flow of {shape[1]}x{shape[0]} stands still; leave out its speed of {speed:g}")
        return speed / fastest

    def at(t: float, shape: Shape) -> Tensor:
        place = min(max(t, 0.0), len(flows) - 1.0)
        before = int(place)
        after = min(before + 1, len(flows) - 1)
        return factor(tuple(shape)) * fitted(torch.lerp(flows[before], flows[after], place - before), shape)

    return Field(at, steady=len(flows) == 1)


def resampled(flow: Tensor, shape: Shape) -> Tensor:
    """A flow (2, H, W) stretched over a frame of another (height, width), its vectors in that frame's pixels."""
    check_vectors(flow)
    frame = whole_sizes(shape, 2, "the frame's shape")
    height, width = flow.shape[1:]
    if (height, width) == frame:
        return flow
    factor = flow.new_tensor([frame[1] / width, frame[0] / height]).view(2, 1, 1)
    return F.interpolate(flow[None], frame, mode="bilinear", align_corners=False, antialias=True)[0] * factor


def _check_speed(speed: float) -> None:
    if not math.isfinite(speed):
        raise InputError(f"a flow's speed is {speed}; give a finite number of pixels per frame")
