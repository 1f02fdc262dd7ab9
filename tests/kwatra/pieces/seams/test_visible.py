"""What is seen of seams: nothing within copies, and as much as pixels differ between them."""

import pytest
import torch

from kwatra import Exemplar
from kwatra.pieces import visible_seams


def where(*columns: int) -> torch.Tensor:
    """A source map (2, 4, n) that shows so many columns of an exemplar in a row."""
    rows, line = torch.meshgrid(torch.arange(4), torch.tensor(columns), indexing="ij")
    return torch.stack([rows, line])


def test_only_seams_between_unlike_pixels_are_seen() -> None:
    halves = torch.zeros(1, 4, 8)
    halves[..., 4:] = 1.0
    exemplar = Exemplar.of(halves)
    assert visible_seams(exemplar, where(2, 3, 4, 5)) == 0  # one copy, edge and all
    assert visible_seams(exemplar, where(0, 1, 0, 1)) == 0  # a seam where all is alike
    # A ends at 0 0, where B shows 1 1: both pixels differ by the range, two deviations each; 4 of 16 pixels have a seam
    assert visible_seams(exemplar, where(0, 1, 6, 7)) == pytest.approx((2 * 1.0 / (2 * 0.5) - 0.1) * 4 / 16, rel=1e-3)


def test_a_flat_exemplar_has_none() -> None:
    assert visible_seams(Exemplar.of(torch.full((1, 4, 8), 0.5)), where(0, 3, 1, 2)) == 0
