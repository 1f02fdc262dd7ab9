import pytest
import torch

from kwatra.base import continued, nearest_known, nearest_owned


@pytest.mark.parametrize(("shape", "spacing"), [((9, 7), None), ((8, 11), (1.0, 2.5)), ((4, 5, 6), (0.5, 1.0, 3.0))])
def test_no_known_pixel_is_nearer_than_the_one_that_is_found(shape, spacing):
    known = torch.rand(shape, generator=torch.Generator().manual_seed(1)) < 0.15
    found, units = nearest_known(known, spacing), torch.tensor(spacing or [1.0] * len(shape))
    assert found.dtype == torch.long
    assert bool(known[tuple(found)].all())
    here = torch.stack(torch.meshgrid(*map(torch.arange, shape), indexing="ij")).flatten(1).T
    away = torch.cdist(here * units, known.nonzero() * units).amin(1)
    torch.testing.assert_close(((found.flatten(1).T - here) * units).norm(dim=1), away)


def test_what_is_nobodys_is_the_nearest_pixel_and_found_once() -> None:
    picture, owner = torch.rand(2, 20, 30, generator=torch.Generator().manual_seed(3)), torch.zeros(20, 30)
    owner[6:12, 9:15] = -1
    owner[:, 25:] = -1
    found, filled = nearest_owned(owner), continued(picture, owner)
    assert nearest_owned(owner) is found
    assert torch.equal(filled, picture[:, found[0], found[1]])
    mine = (owner >= 0).nonzero()
    for row, column in ((0, 0), (7, 10), (9, 12), (3, 29), (19, 25)):
        away = (mine - torch.tensor([row, column])).square().sum(1)
        assert int((found[:, row, column] - torch.tensor([row, column])).square().sum()) == int(away.min())
    assert torch.equal(continued(picture, torch.zeros(20, 30)), picture)


def test_a_canvas_in_space_and_time_is_filled_too() -> None:
    owner = torch.zeros(3, 4, 5)
    owner[1] = -1
    owner[0, 0, 0] = -1
    owner[2] = -1
    values = torch.arange(60.0).view(1, 3, 4, 5)
    made = continued(values, owner)[0]
    assert torch.equal(made[1][1:], values[0, 0][1:])
    assert torch.equal(made[2][1:], values[0, 0][1:])
    assert float(made[0, 0, 0]) in (1.0, 5.0)


def test_of_what_is_known_everywhere_each_is_nearest_to_itself() -> None:
    everywhere = nearest_known(torch.ones(3, 4, dtype=torch.bool))
    assert torch.equal(everywhere, torch.stack(torch.meshgrid(torch.arange(3), torch.arange(4), indexing="ij")))
