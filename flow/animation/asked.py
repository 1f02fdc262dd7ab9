"""What is asked of an animation, and whether it can be done."""

from collections.abc import Callable, Sequence

import torch
from torch import Tensor

from flow.animation.carrying import enters
from flow.animation.film import Film
from flow.animation.state import State
from flow.fields import Field, Shape
from kwatra import Exemplar, InputError
from kwatra.base import check_mask, tensor_of, total, whole_sizes

Mask = Tensor | Callable[[int], Tensor] | None

_NEARLY_RIGID = 0.25
"""A flow is nearly rigid whose squared rates of strain sum to at most so much of its squared rates of rotation; a shear
has as much of both. Made stones in a pair of vortices, which has more strain, follow it worse where they turn (epe .31
px for .27) and are cut as often."""


def frame_of(shape: Sequence[int]) -> Shape:
    """The height and width of frames as ints; InputError for what are none."""
    height, width = whole_sizes(shape, 2, "the frames' shape")
    return height, width


def film_of(
    exemplar: Exemplar | Tensor, also: Exemplar | Tensor | None, turn: bool | None, field: Field, shape: Shape
) -> Film:
    """The film of an exemplar and its maps, given as such or as tensors; see `Film.of`.

    turn: whether copies may turn; None: where the first flow is nearly rigid, and the exemplar prefers no direction.
    """
    own, maps = (Exemplar.of(given) if isinstance(given, Tensor) else given for given in (exemplar, also))
    if not isinstance(own, Exemplar):
        raise InputError(f"the exemplar is a {type(own).__name__}; give a tensor (C, H, W), or a video (C, T, H, W)")
    if not isinstance(field, Field):
        raise InputError(f"the flow is a {type(field).__name__}; give a field: `sampled` makes one of tensors, `Field` "
                         "of a function")  # fmt: skip
    return Film.of(own, maps, False if turn is None and not _nearly_rigid(field(0, shape)) else turn)


def _nearly_rigid(flow: Tensor) -> bool:
    """Whether a flow (2, H, W) moves and turns what it carries more than it bends it."""
    right, down = (flow.diff(dim=2)[:, :-1], flow.diff(dim=1)[:, :, :-1])
    strain = right[0].square() + down[1].square() + (right[1] + down[0]).square() / 2
    rotation = (right[1] - down[0]).square() / 2
    return float(total(strain)) <= _NEARLY_RIGID * float(total(rotation)) + 1e-8 * flow[0].numel()


def allowed(mask: Mask, number: int, shape: Shape) -> Tensor:
    """Where (H, W) texture may be in a frame; InputError for a mask of another size or type."""
    if mask is None:
        return torch.ones(shape, dtype=torch.bool)
    now = mask(number) if callable(mask) else tensor_of(mask)
    check_mask(now, shape)
    return now.contiguous()


def check(film: Film, field: Field, shape: Shape, mask: Mask, enter: str | None, state: State | None) -> None:
    """Refuse with InputError a field or a mask that does not fit the frame, or a state of another size."""
    number = 0 if state is None else state.number
    flow = field(number, shape)
    allowed(mask, number, shape)
    if state is not None and tuple(state.inside.shape) != tuple(shape):
        size, asked = "x".join(map(str, state.inside.shape)), "x".join(map(str, shape))
        raise InputError(f"the state to go on from has frames of {size} (HxW), not {asked}; give that shape")
    want = len(film.strip.canvas) + (0 if film.also is None else len(film.also.canvas))
    if state is not None and len(state.image) != want:
        have = len(state.image)
        raise InputError(f"the state to go on from has {have} channels, the exemplar {want}; give that it was made of")
    if state is None and enter and field.steady and not bool(enters(flow, enter).any()):
        side = "any side" if enter == "all" else f"the {enter}"
        raise InputError(f"texture is to enter from {side}, but the flow never comes from there; give another side")
