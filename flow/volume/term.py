"""The flow energy of a whole video, for videos that flow as published (thesis section 7.1).

All frames are unknown together: the blend solves for the volume in which windows agree and pixels keep their color
along the flow, by conjugate gradients.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import torch
from torch import Tensor

from flow.checks import check_vectors
from flow.volume.candidates import Candidates
from flow.volume.springs import Springs, coarser, coarser_mask
from kwatra import InputError, Quadratic, Term
from kwatra.base import coarse_shape


@dataclass(frozen=True, eq=False)
class VolumeFlow(Term):
    """weight * sum over (p, i) of (x(p, i) - x(q, i + 1))^2 with q = f_i(p), over the number of values (equation 29).

    flows: (T - 1, 2, H, W), forward, x first, in pixels per frame: flow i leads from frame i to the next. loop: there
    are T, and the last frame leads to the first. wrap: frames are periodic, as with `Settings.wrap`. mask (T, H, W):
    True where there is texture. Between pixels frames are read bilinearly; what flows beyond the frame is free. Raises
    InputError for flows that are no finite (N, 2, H, W), or of another size than the video.
    """

    flows: Tensor
    weight: float = 1.0
    loop: bool = False
    wrap: bool = False
    mask: Tensor | None = None

    def __post_init__(self) -> None:
        if self.flows.ndim != 4:
            raise InputError(f"flows have shape {tuple(self.flows.shape)}; give one (2, H, W) for each frame, stacked")
        for flow in self.flows:
            check_vectors(flow)
        if self.loop and len(self.flows) < 2:
            raise InputError(f"a loop has {len(self.flows)} frames; give a flow for each of at least 2")
        if not (0 <= self.weight < float("inf")):
            raise InputError(f"the weight of the flow is {self.weight}; it is finite and >= 0")

    @property
    def name(self) -> str:
        """What it is called in reports."""
        return "flow"

    @property
    def shape(self) -> tuple[int, int, int]:
        """(T, H, W) of the video."""
        height, width = self.flows.shape[2:]
        return len(self.flows) + (not self.loop), height, width

    def at(self, factor: tuple[int, ...], shape: tuple[int, ...]) -> "VolumeFlow":
        """Flows are averaged over blocks and counted in their pixels; time keeps its resolution."""
        if len(factor) != 3 or factor[0] != 1 or coarse_shape(self.shape, factor) != tuple(shape):
            whole = tuple(size * f for size, f in zip(shape, factor, strict=True))
            raise InputError(
                f"the flows are for a video of shape {self.shape}, but the output is {whole}; give a flow of its size "
                "from each frame to the next"
            )
        if all(f == 1 for f in factor):
            return self
        mask = None if self.mask is None else coarser_mask(self.mask, factor)
        return replace(self, flows=coarser(self.flows, factor[1:], self.mask), mask=mask)

    def within(self, mask: Tensor) -> "VolumeFlow":
        """Without what flows to or from behind the mask."""
        return replace(self, mask=mask)

    @cached_property
    def springs(self) -> Springs:
        """What the energy is made of."""
        return Springs(self.flows, self.shape, self.wrap, self.mask)

    def quadratic(self, x: Tensor) -> Quadratic:
        """F: the springs; c: 0."""
        springs, weight = self.springs, self.weight
        return Quadratic(weight * springs.diagonal, torch.zeros_like(x[:1]), lambda v: weight * springs.times(v))

    def charge(self, x: Tensor | None, step: object = None) -> Candidates:
        """What candidates cost with the rest of the video x (C, T, H, W) as it is: lambda U_c of thesis equation 31."""
        return Candidates(self.springs, self.weight, x)
