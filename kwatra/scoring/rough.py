"""About how good a texture is, at little cost: to tell, and to choose among several by."""

from collections.abc import Sequence
from threading import Lock

import torch
from torch import Tensor

from kwatra.scoring.joint import JointStatistics, largest_side
from kwatra.scoring.nearest import WINDOW, Nearest, Windows, one_thread
from kwatra.scoring.pixels import gradient, ratio, unit
from kwatra.scoring.quality import Images, carried_scales, measure, read
from kwatra.scoring.sliced import sliced_distance

GLANCES, MOST = 300, 1024
"""About so many windows are looked up, of so many pixels a side."""

COMPONENTS = 12
"""Principal components that windows are searched by. Figures of a photograph differ by .6% from those by 32."""

JOINT = 0.2
"""What joint statistics count in a thorough ranking: as one of five figures."""

CHANNELS = 16
"""Windows of more channels have too many values for principal components: minutes, where they end at all."""


def glance(output: Tensor, exemplar: Images) -> float:
    """About what `measure` calls overall, at a tenth of its cost: one scale (2 where it fits), fewer windows.

    Shapes and errors as in `measure`, but of images alone; of large ones the middle is looked at. On eight syntheses of
    256x256 it was within 15% of that figure.
    """
    frames, images = read(output, exemplar)
    return _Sight(images, _scale(output, exemplar)).figure(frames)


class Ranking:
    """Tells about the overall figure of outputs of an exemplar, to choose among them by; lower is better.

    Of videos it is that of `measure`, of images a `glance`, for which the exemplar is described once. thorough: the
    joint statistics of images count as well, where 64x64 pixels fit; to load what finds them takes a second.

    Shapes as there, and pictures of any size and many channels: where a picture is too small for a window each pixel
    counts as so many squared; of more than CHANNELS channels the first are looked at.
    """

    def __init__(self, exemplar: Images, thorough: bool = False) -> None:
        self._images = [exemplar] if isinstance(exemplar, Tensor) else list(exemplar)
        self._sights: dict[tuple[int, int], _Sight] = {}
        self._thorough = thorough
        self._joint: dict[int, JointStatistics] = {}
        self._describing = Lock()  # threads may ask at once; the exemplar is described by the first

    def __call__(self, output: Tensor) -> float:
        """The figure of an output (C, H, W), or (C, T, H, W)."""
        times, (shown, *images) = self._enlarged_to_fit(output)
        if output.ndim == 4:
            return measure(shown, images)["overall"]
        frames, sources = read(shown, images)
        sight, joint = self._described(times, frames, sources)
        figure = sight.figure(frames)
        return figure if joint is None else (1 - JOINT) * figure + JOINT * joint.distance(frames)

    def describe(self, shape: Sequence[int]) -> None:
        """Describe the exemplar for images of a shape (C, H, W): else done for the first that is told about."""
        times, (shown, *images) = self._enlarged_to_fit(torch.zeros(*shape, dtype=torch.float32))
        self._described(times, *read(shown, images))

    def _enlarged_to_fit(self, output: Tensor) -> tuple[int, list[Tensor]]:
        """How many times an output and the exemplar's images are enlarged, so that windows fit, and they so."""
        shortest = min(min(image.shape[-2:]) for image in (output, *self._images))
        times = -(-WINDOW // shortest)
        return times, [_enlarged(image[:CHANNELS], times) for image in (output, *self._images)]

    def _described(
        self, times: int, frames: Sequence[Tensor], sources: Sequence[Tensor]
    ) -> tuple["_Sight", JointStatistics | None]:
        """The exemplar's images as they are seen beside such frames, and their joint statistics where these count."""
        scale = _scale(frames[0], sources)
        side = largest_side([*frames, *sources]) if self._thorough else None
        with self._describing:
            if (times, scale) not in self._sights:
                self._sights[times, scale] = _Sight(sources, scale)
            if side is not None and side not in self._joint:
                self._joint[side] = JointStatistics(sources, side)
        return self._sights[times, scale], None if side is None else self._joint[side]


class _Sight:
    """Images (C, H, W) of an exemplar as a glance sees them at one scale."""

    @one_thread
    def __init__(self, images: Sequence[Tensor], scale: int) -> None:
        self.images, self.scale = [_middle(image) for image in images], scale
        windows = Windows.of(self.images, WINDOW, scale)
        self.nearest = Nearest(windows, components=COMPONENTS)
        self.rows = windows.rows(windows.sample(GLANCES))
        self.many = windows.rows(windows.sample(4 * GLANCES))

    @one_thread
    def figure(self, frames: Sequence[Tensor]) -> float:
        """The figure of an output's frames (C, H, W)."""
        frames = [_middle(frame) for frame in frames]
        windows = Windows.of(frames, WINDOW, self.scale)
        forward, _ = self.nearest.search(windows.rows(windows.sample(GLANCES)))
        coverage, _ = Nearest(windows, self.nearest).search(self.rows)
        sliced = sliced_distance(windows.rows(windows.sample(4 * GLANCES)), self.many)
        off = abs(1 - ratio(gradient(frames), gradient(self.images)))
        return ((float(forward.mean()) + float(coverage.mean()) + sliced) / unit(self.images) + off) / 4


def _scale(output: Tensor, exemplar: Images) -> int:
    """The coarsest scale up to 2 that every image has room for."""
    return [scale for scale in carried_scales(output, exemplar) if scale <= 2][-1]


def _enlarged(image: Tensor, times: int) -> Tensor:
    return image.repeat_interleave(times, -1).repeat_interleave(times, -2)


def _middle(image: Tensor) -> Tensor:
    """An image (C, H, W), no more of it than MOST pixels a side."""
    for axis, side in enumerate(image.shape[1:], 1):
        image = image.narrow(axis, max(side - MOST, 0) // 2, min(side, MOST))
    return image
