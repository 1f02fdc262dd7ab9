import pytest
import torch

from kwatra.base import nearest_known


@pytest.mark.parametrize(("shape", "spacing"), [((9, 7), None), ((8, 11), (1.0, 2.5)), ((4, 5, 6), (0.5, 1.0, 3.0))])
def test_no_known_pixel_is_nearer_than_the_one_that_is_found(shape, spacing):
    known = torch.rand(shape, generator=torch.Generator().manual_seed(1)) < 0.15
    found, units = nearest_known(known, spacing), torch.tensor(spacing or [1.0] * len(shape))
    assert found.dtype == torch.long
    assert bool(known[tuple(found)].all())
    here = torch.stack(torch.meshgrid(*map(torch.arange, shape), indexing="ij")).flatten(1).T
    away = torch.cdist(here * units, known.nonzero() * units).amin(1)
    torch.testing.assert_close(((found.flatten(1).T - here) * units).norm(dim=1), away)
