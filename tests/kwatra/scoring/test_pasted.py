"""How large the copies of a source map are."""

import pytest
import torch

from kwatra.scoring import pasted


def test_pasted_is_the_mean_area_of_copies_weighted_by_area() -> None:
    where = torch.stack(torch.meshgrid(torch.arange(6), torch.arange(8), indexing="ij"))
    assert pasted(where + 5, area=96) == pytest.approx(48 / 96)
    where[:, :, 6:] += 3  # 36 pixels and 12
    assert pasted(where, area=96) == pytest.approx((36 * 36 + 12 * 12) / 48 / 96)
    where[:, :, 2:4] += 7  # one offset on both sides of it, but 12 pixels each
    assert pasted(where, area=96) == pytest.approx(12 / 96)
