"""Values that users give become tensors, whatever arrays they come in."""

import warnings

import numpy as np
import pytest
import torch

from kwatra import InputError
from kwatra.base import device_of, tensor_of


def of_pixels() -> np.ndarray:
    return np.arange(12, dtype=np.float32).reshape(3, 4)


def readonly() -> np.ndarray:
    values = of_pixels()
    values.setflags(write=False)
    return values


@pytest.mark.parametrize(
    "values",
    [of_pixels()[::-1, ::-1][::-1, ::-1], of_pixels()[::-1].copy()[::-1], of_pixels().astype(">f4"), readonly()],
    ids=["flipped twice", "flipped", "of foreign bytes", "not to be written to"],
)
def test_arrays_that_torch_does_not_take_are_copied(values: np.ndarray) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = tensor_of(values)
    assert made.dtype == torch.float32
    assert made.tolist() == values.tolist()


def test_others_are_not_copied() -> None:
    values, tensor = of_pixels(), torch.arange(3)
    assert tensor_of(values).data_ptr() == values.ctypes.data
    assert tensor_of(tensor) is tensor
    assert tensor_of([[1.0, 2.0]]).tolist() == [[1.0, 2.0]]


@pytest.mark.parametrize(
    "values",
    [
        np.zeros(3, complex),
        torch.zeros(3, dtype=torch.complex64),
        np.zeros(3, np.longdouble),
        np.zeros(3, object),
        np.array(["a"]),
        [[1, 2], [3]],
        None,
        "a name",
    ],
)
def test_what_is_no_array_of_real_numbers_is_refused(values: object) -> None:
    with pytest.raises(InputError, match="give whole or real numbers of up to 64 bits, or booleans"):
        tensor_of(values)


def test_derivatives_end_there() -> None:
    assert not tensor_of(torch.ones(2, requires_grad=True)).requires_grad


@pytest.mark.parametrize("name", ["nowhere", "cuda:99", None])
def test_a_device_there_is_not_is_refused(name: str) -> None:
    with pytest.raises(InputError, match=f"the device '{name}' cannot be used"):
        device_of(name)
    assert device_of("cpu") == torch.device("cpu")
