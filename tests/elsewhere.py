"""A device beside the CPU, made believe: its tensors are the CPU's, but refuse what a graphics card's would refuse.

They name themselves on the device "meta". Tensors of two devices in one operation raise RuntimeError, and so do random
numbers drawn there by a generator of the CPU; what is copied from one to the other is counted.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any
from unittest.mock import patch

import torch
from torch import Tensor
from torch.overrides import TorchFunctionMode
from torch.utils._python_dispatch import TorchDispatchMode

aten = torch.ops.aten
NAME = "meta"
COPIES = (aten.copy_.default, aten._to_copy.default)
LOOKUPS = (aten.index.Tensor, aten.index_put_.default, aten._index_put_impl_.default)  # numbers may be the CPU's


class Elsewhere(Tensor):
    """A tensor of the other device; `here` holds its values."""

    here: Tensor

    @staticmethod
    def __new__(cls, here: Tensor) -> "Elsewhere":
        made = Tensor._make_wrapper_subclass(
            cls, here.size(), strides=here.stride(), storage_offset=here.storage_offset(), dtype=here.dtype, device=NAME
        )
        made.here = here
        return made

    __torch_function__ = torch._C._disabled_torch_function_impl

    @classmethod
    def __torch_dispatch__(cls, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        return _computed(func, args, kwargs or {})


def _computed(func: Any, args: Any, kwargs: dict[str, Any]) -> Any:
    """What an operation gives, on the device on which its tensors are; RuntimeError if that is not one."""
    given = list(_each((*args, *kwargs.values())))
    tensors = [each for each in given if isinstance(each, Tensor)]
    there = [each for each in tensors if isinstance(each, Elsewhere)]
    sized = [each for each in tensors if not isinstance(each, Elsewhere) and each.ndim]
    if func in LOOKUPS:
        sized = [each for each in sized if any(each is other for other in (args[0], *args[2:3]))]
    if there and sized and func not in COPIES:
        raise RuntimeError(f"tensors of two devices in {func}")
    asked = kwargs.get("device")
    away = bool(there) if asked is None else torch.device(asked).type == NAME
    if func is aten.copy_.default:
        away = isinstance(args[0], Elsewhere)
    if away and any(isinstance(each, torch.Generator) for each in given):
        raise RuntimeError(f"a generator of the CPU in {func} elsewhere")
    inner, options = _here(args), {name: _here(value) for name, value in kwargs.items()}
    if asked is not None:
        options["device"] = "cpu"
    result = func(*inner, **options)
    first = func._schema.arguments[0].alias_info if func._schema.arguments else None
    if first is not None and first.is_write:
        return args[0]  # in place
    return _there(result) if away else result


def _each(values: Iterable[Any]) -> Iterator[Any]:
    """What is in lists and tuples, whatever their depth; torch's own way takes half the time of these tests."""
    for value in values:
        if isinstance(value, list | tuple):
            yield from _each(value)
        else:
            yield value


def _here(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return type(value)(map(_here, value))
    return value.here if isinstance(value, Elsewhere) else value


def _there(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return type(value)(map(_there, value))
    return Elsewhere(value) if isinstance(value, Tensor) else value


class _Operations(TorchDispatchMode):
    def __init__(self) -> None:
        super().__init__()
        self.moved = 0

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        result = _computed(func, args, kwargs or {})
        if func in COPIES or func is aten._local_scalar_dense.default:
            ends = [result, *args[:2]] if func is aten.copy_.default else [result, args[0]]
            self.moved += len({isinstance(end, Elsewhere) for end in ends}) > 1
        return result


class _Making(TorchFunctionMode):
    """What torch does in C++ before an operation is seen: tensors made of numbers, and numbers of tensors."""

    def __torch_function__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        options = dict(kwargs or {})
        if func in (torch.tensor, torch.as_tensor) and torch.device(options.get("device") or "cpu").type == NAME:
            options.pop("device")
            return func(*args, **options).to(NAME)
        if args and isinstance(args[0], Elsewhere):
            if func is Tensor.tolist:
                return args[0].cpu().tolist()
            if func is Tensor.__getitem__ and isinstance(args[1], list):
                return args[0][torch.tensor(args[1])]
        return func(*args, **options)


_NEW_TENSOR = Tensor.new_tensor


def _new_tensor(self: Tensor, data: Any, **options: Any) -> Tensor:
    if isinstance(self, Elsewhere):  # also where gradients are found, in a thread without modes
        return Elsewhere(torch.tensor(data, dtype=options.get("dtype") or self.dtype))
    return _NEW_TENSOR(self, data, **options)


@contextmanager
def elsewhere() -> Iterator[_Operations]:
    """Within it there is the device `NAME`; of what it gives, `moved` is how many tensors went to it or from it."""
    with patch.object(Tensor, "new_tensor", _new_tensor), _Operations() as operations, _Making():
        yield operations
