"""What a flow must be: one place that says so, in a sentence."""

from collections.abc import Sequence

from torch import Tensor

from kwatra.base import InputError


def check_vectors(flow: Tensor, shape: Sequence[int] | None = None) -> None:
    """Refuse with InputError what is not (2, H, W) of finite numbers, or of another (height, width) than `shape`."""
    if not isinstance(flow, Tensor):
        raise InputError(f"a flow is {type(flow).__name__}; give a tensor of floats (2, H, W), x first")
    if flow.ndim != 3 or flow.shape[0] != 2 or not flow.is_floating_point():
        raise InputError(f"a flow has shape {tuple(flow.shape)} and type {flow.dtype}; give floats (2, H, W), x first")
    height, width = flow.shape[1:]
    if shape is not None and (height, width) != tuple(shape):
        raise InputError(
            f"a flow is {width}x{height} but the frame {shape[1]}x{shape[0]}; give one of that size, or resample it"
        )
    finite = flow.isfinite().all(0)
    if not bool(finite.all()):
        raise InputError(f"a flow has {int((~finite).sum())} vectors that are NaN or infinite; fill them or mend them")


def check_flow(flow: Tensor, shape: Sequence[int] | None = None) -> None:
    """Refuse with InputError what `check_vectors` does, and a flow that moves pixels beyond the frame."""
    check_vectors(flow, shape)
    height, width = flow.shape[1:]
    far = (flow[0].abs() >= width) | (flow[1].abs() >= height)
    if bool(far.any()):
        longest = float(flow.norm(dim=0).max())
        raise InputError(
            f"a flow moves pixels by up to {longest:.4g} px, beyond the {width}x{height} frame; give a lower speed"
        )
