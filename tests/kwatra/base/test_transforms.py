import re
from pathlib import Path

import numpy as np
import pytest
import torch

from kwatra.base.transforms import backward, fast, forward, of_complex, of_real, to_complex, to_real

SIZES = [(6,), (10, 9), (5, 12, 8)]


@pytest.mark.parametrize("size", SIZES)
def test_transforms_of_real_values_are_numpys_with_zeros_behind_them(size: tuple[int, ...]) -> None:
    values = torch.rand(2, 3, *(n - 2 for n in size), dtype=torch.float64)
    axes = tuple(range(-len(size), 0))
    np.testing.assert_allclose(of_real(values, size), np.fft.rfftn(values, size, axes), atol=1e-12)


@pytest.mark.parametrize("size", SIZES)
def test_they_lead_back_to_the_values_or_the_first_of_them(size: tuple[int, ...]) -> None:
    values = torch.rand(2, *size, dtype=torch.float64)
    room = tuple(n - number for number, n in enumerate(size, 1))
    first = values[(..., *(slice(r) for r in room))]
    np.testing.assert_allclose(to_real(of_real(values, size), size, room), first, atol=1e-12)


@pytest.mark.parametrize("size", SIZES)
def test_arrays_are_transformed_as_tensors_are(size: tuple[int, ...]) -> None:
    values = torch.rand(2, *size, dtype=torch.float64)
    larger = fast([n + 1 for n in size])
    assert all(there >= n + 1 for there, n in zip(larger, size, strict=True))
    spectrum, threads = forward(values.numpy(), larger), torch.get_num_threads()
    np.testing.assert_array_equal(spectrum, of_real(values, larger))
    np.testing.assert_allclose(backward(spectrum, larger, size), values, atol=1e-12)
    assert torch.get_num_threads() == threads


@pytest.mark.parametrize("kind", [torch.float64, torch.complex128])
def test_complex_transforms_are_numpys_and_lead_back(kind: torch.dtype) -> None:
    values = torch.rand(2, 12, 9, dtype=kind)
    spectrum = of_complex(values)
    np.testing.assert_allclose(spectrum, np.fft.fft2(values, norm="ortho"), atol=1e-12)
    np.testing.assert_allclose(to_complex(spectrum), values, atol=1e-12)


def test_nothing_else_transforms_several_complex_axes_at_once() -> None:
    root = Path(__file__).parents[3]
    several = re.compile(r"(?<![a-z_])i?(fft2|fftn|hfft2|hfftn|rfftn|irfftn)\(")
    files = [file for folder in ("kwatra", "flow", "synth") for file in (root / folder).rglob("*.py")]
    found = {file.name for file in files if several.search(file.read_text())}
    assert found == {"transforms.py"}
