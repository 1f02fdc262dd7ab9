"""What an optimization is to do: everything that is the same on all of its levels."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor

from kwatra.base import InputError, check_mask, floats_of, generator_of, whole_sizes
from kwatra.exemplar import Exemplar
from kwatra.levels import Level, finishing, planned_levels
from kwatra.settings import Settings
from kwatra.source import Bags, Prepared, Texture
from kwatra.terms import Controls, HardPixels, Sum, TermLike, check_controls, parts_of
from kwatra.windows import per_axis

STARTS = ("aligned", "blocks", "windows", "terms")


@dataclass(frozen=True, eq=False)
class Task:
    """A texture, the output's spatial shape, how to work, what is asked of it, and the one source of randomness.

    levels: coarse to fine. mask: boolean (*shape), or None where texture belongs everywhere. start: one of STARTS, or
    "image" where `image` (C, *shape) is what to begin with. made: the controls that were asked for, by resolution.
    """

    texture: Texture
    shape: tuple[int, ...]
    settings: Settings
    levels: tuple[Level, ...]
    terms: tuple[TermLike, ...]
    mask: Tensor | None
    start: str
    image: Tensor | None
    generator: torch.Generator
    made: dict[tuple[int, ...], Controls] = field(default_factory=dict)

    @property
    def wraps(self) -> tuple[bool, ...]:
        """Along which axes the output is periodic."""
        return per_axis(self.settings.wrap, len(self.shape))

    @property
    def channels(self) -> int:
        """Number of channels C."""
        return len(self.texture.weights)

    def controls(self, factors: tuple[int, ...]) -> Controls:
        """Terms and mask where pixels are `factors` times coarser; made when they are first asked for, and kept."""
        if factors not in self.made:
            terms, device = self.terms, self.texture.device
            self.made[factors] = Controls(terms, self.mask, factors, self.shape, self.channels, device)
        return self.made[factors]

    def check_start(self) -> None:
        """Refuse with InputError a start of no known name, of terms that are not there, or from an unfit image."""
        if self.image is None:
            if self.start not in STARTS:
                raise InputError(f"the start is {self.start!r}; give an image, or one of {', '.join(STARTS)}")
            if self.start == "terms" and not self.terms:
                raise InputError("the start is 'terms' but there is no term; give one, or another start")
            return
        if tuple(self.image.shape) != (self.channels, *self.shape):
            raise InputError(
                f"the start image has shape {tuple(self.image.shape)}; the output needs {(self.channels, *self.shape)}"
            )
        if not bool((self.image if self.mask is None else self.image[:, self.mask]).isfinite().all()):
            raise InputError("the start image holds NaN or infinite pixels; replace them first")


def task_of(
    texture: Exemplar | Prepared | Texture,
    shape: Sequence[int],
    settings: Settings,
    terms: TermLike | Sum | Sequence[TermLike | Sum],
    mask: Tensor | None,
    start: Tensor | str,
    seed: int,
) -> Task:
    """The task, checked: InputError for what cannot be done."""
    texture = Prepared(texture) if isinstance(texture, Exemplar) else texture
    if not hasattr(texture, "exemplar"):
        raise InputError(f"the texture is {type(texture).__name__}; give an Exemplar, as Exemplar.of(image) makes it")
    shape = whole_sizes(shape, _axes(texture, shape))
    if mask is not None:
        check_mask(mask, shape)
        mask = None if bool(mask.all()) else mask
    parts = parts_of(terms)
    name, image = (start, None) if isinstance(start, str) else ("image", floats_of(start))
    steered = name != "aligned" or not all(isinstance(part, HardPixels) for part in parts)
    levels = _levels(texture, shape, settings, steered)
    task = Task(texture, shape, settings, levels, parts, mask, name, image, generator_of(seed))
    per_axis(settings.wrap, len(shape))
    task.check_start()
    if parts:
        check_controls(task.controls((1,) * len(shape)), None if texture.exemplar is None else texture.exemplar.shape)
    return task


def _axes(texture: Texture, shape: Sequence[int]) -> int:
    """How many axes an output of this texture has."""
    if isinstance(texture, Bags):
        return next(iter(texture.windows.values())).ndim - 2
    return len(shape) if texture.exemplar is None else len(texture.exemplar.shape)


def _levels(texture: Texture, shape: tuple[int, ...], settings: Settings, steered: bool) -> tuple[Level, ...]:
    """The levels asked for, or planned ones; of bags, one for each.

    steered: whether terms or the start ask for what blocks laid for their seams alone would not bring. Hard pixels do
    not: blocks are laid to agree with them, and coarse levels only undo that. Around a piece of the exemplar that is
    kept (ten textures, two seeds) colors step 1.2 times as much as elsewhere, and .08 of the elements are cut; with all
    levels 1.9 times and .18.
    """
    if settings.levels is not None:
        if texture.exemplar is not None:
            _check_levels(settings.levels, texture.exemplar.extent)
        return settings.levels
    if isinstance(texture, Bags):
        return tuple(Level(factor, width, settings.iterations) for factor, width in texture.windows)
    if texture.exemplar is None:
        raise InputError("a texture without an exemplar has no levels of its own; give some in the settings")
    planned = planned_levels(texture.exemplar, shape, settings.iterations)
    return planned if steered or len(shape) > 2 else finishing(planned)


def _check_levels(levels: Sequence[Level], extent: tuple[int, ...]) -> None:
    """Refuse with InputError levels so coarse that nothing is left of an exemplar of some extent."""
    coarsest = max(levels, key=lambda level: level.factor)
    if any(side < factor for side, factor in zip(extent, coarsest.factors(len(extent)), strict=True)):
        size = "x".join(map(str, extent))
        raise InputError(
            f"a level is {coarsest.factor} times coarser but the exemplar has only {size} pixels; "
            "choose finer levels or a larger exemplar"
        )
