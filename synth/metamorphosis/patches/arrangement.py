"""Which neighborhood lies where: what carries a frame of a metamorphosis over to the next."""

from dataclasses import dataclass

import torch
from scipy.spatial import cKDTree
from torch import Tensor

from kwatra import FreeWindows
from kwatra.windows.metric import falloff
from synth.metamorphosis.patches.model import Matched
from synth.metamorphosis.patches.weighting import Weighting


@dataclass(frozen=True)
class Arrangement:
    """Neighborhoods of a level, by number (N,), and the windows that they are pasted into."""

    matched: Matched
    layout: FreeWindows
    numbers: Tensor

    @classmethod
    def of(
        cls, matched: Matched, texture: int, where: Tensor, layout: FreeWindows, zoom: float = 1.0, margin: int = 0
    ) -> "Arrangement":
        """That of a picture of one texture, made of its own windows as a source map says.

        where (2, h, w): row and column in the texture of each pixel of the picture, which is shown `zoom` times larger,
        and continued by `margin` pixels. layout: where windows should lie; each is moved by up to a few pixels, or as
        far as it lies beyond the picture, so that what it shows stays in place.
        """
        shape, half = layout.shape, layout.width[0] // 2
        middle = layout.corners + half
        place = (((middle - margin).float() + 0.5) / zoom).floor().long()
        inside = place.clamp(min=0).minimum(torch.tensor(where.shape[1:]) - 1)
        wanted = where[:, inside[:, 0], inside[:, 1]].T + place - inside
        own = (matched.neighborhoods.anchor == texture).nonzero()[:, 0]
        centers = matched.neighborhoods.centers[own, texture]
        near = torch.from_numpy(cKDTree(centers.numpy()).query(wanted.numpy())[1])
        moved = middle + ((centers[near] - wanted).float() * zoom).round().long() - half
        last = torch.tensor(shape) - torch.tensor(layout.width)
        wraps = torch.tensor(layout.wraps)
        moved = torch.where(wraps, moved % torch.tensor(shape), moved.clamp(min=0).minimum(last))
        return cls(matched, FreeWindows(shape, layout.width, moved, layout.wrap), own[near])

    def pasted(self, weighting: Weighting, below: Tensor | None = None) -> Tensor:
        """The mean of what lies at each pixel, in between: colors and distance, (C + 1, *S).

        below: shown where nothing lies; zeros by default.
        """
        width = self.layout.width[0]
        chosen = weighting.at(self.layout.corners, width)
        weight = falloff(self.layout.width)[..., None]
        mass, total = (
            torch.zeros(1, *self.layout.shape, dtype=torch.float32),
            torch.zeros(1, *self.layout.shape, dtype=torch.float32),
        )
        for number in chosen.unique().tolist():
            some = (chosen == number).nonzero()[:, 0]
            windows = self.matched.windows(self.numbers[some], weighting.palette[number])
            part = FreeWindows(self.layout.shape, self.layout.width, self.layout.corners[some], self.layout.wrap)
            mass = mass + part.scatter(weight.expand(len(some), *weight.shape).contiguous())
            total = total + part.scatter(windows * weight)
        return torch.where(mass > 0, total / mass.clamp(min=1e-12), 0.0 if below is None else below)
