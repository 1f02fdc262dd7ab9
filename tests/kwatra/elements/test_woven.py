import pytest
import torch

from kwatra import Exemplar
from kwatra.base import generator_of
from kwatra.elements import Lattice, continued_weave, find_weave, lines_through, woven
from kwatra.elements.woven import Cell, Weave, _lines, in_step
from kwatra.source import look_up

SETT = torch.tensor([0] * 10 + [1] * 4 + [2] * 12 + [1] * 3 + [0] * 6 + [3] * 13)
COLORS = torch.rand(4, 3, generator=torch.Generator().manual_seed(0))


def tartan(height: int, width: int, first: tuple[int, int] = (0, 0), grain: float = 0.0) -> torch.Tensor:
    """A tartan (3, H, W) of 48 px, from a row and a column on; grain: standard deviation of noise."""
    down, across = (COLORS[SETT[(torch.arange(n) + f) % 48]].T for n, f in zip((height, width), first, strict=True))
    noise = torch.randn(3, height, width, generator=torch.Generator().manual_seed(1))
    return (down[:, :, None] + across[:, None]) / 2 + grain * noise


def places(image: torch.Tensor, shape: tuple[int, int], wraps=(False, False), seed: int = 0) -> torch.Tensor | None:
    exemplar = Exemplar.of(image)
    return continued_weave(exemplar, find_weave(exemplar), shape, wraps, generator_of(seed))


def continued(image: torch.Tensor, shape: tuple[int, int], wraps: tuple[bool, bool] = (False, False)) -> torch.Tensor:
    where = places(image, shape, wraps)
    assert where is not None
    assert (where[0] == where[0, :, :1]).all()
    assert (where[1] == where[1, :1]).all()
    return look_up(image, where)


@pytest.mark.parametrize("shape", [(100, 110), (64, 70)])
@pytest.mark.parametrize("first", [(0, 0), (17, 31)])
def test_a_tartan_goes_on_by_its_period(shape, first):
    image = tartan(*shape, first)
    weave = find_weave(Exemplar.of(image))
    assert weave is not None
    rows, columns = weave.cells
    assert (rows.length, columns.length) == (48, 48)
    begun = first[0] + rows.first, first[1] + columns.first
    assert torch.equal(continued(image, (200, 300)), tartan(200, 300, begun))


def test_grain_does_not_hide_a_period():
    (rows, columns), _ = find_weave(Exemplar.of(tartan(100, 110, grain=0.06)))
    assert (rows.length, columns.length) == (48, 48)


def test_a_period_of_half_pixels_is_doubled():
    y, x = torch.meshgrid(torch.arange(64), torch.arange(64), indexing="ij")
    wave = ((torch.sin(2 * torch.pi * y / 12.5) + torch.sin(2 * torch.pi * x / 9)) / 4 + 0.5)[None]
    (rows, columns), _ = find_weave(Exemplar.of(wave))
    assert (rows.length, columns.length) == (25, 9)


def test_a_whole_sett_goes_on_with_its_first_line():
    assert torch.equal(continued(tartan(48, 48, (5, 7)), (130, 96)), tartan(130, 96, (5, 7)))


def test_what_shows_no_period_goes_on_where_its_lines_join_and_mostly_on_end():
    image = tartan(40, 44, (3, 20))
    (rows, columns), _ = find_weave(Exemplar.of(image))
    assert min(rows.length, columns.length) >= 20
    made = continued(image, (120, 120))
    for lines, given in ((made[:, :, 0], image[:, :, columns.first]), (made[:, 0], image[:, rows.first])):
        steps = (lines[:, 1:] - lines[:, :-1]).square().sum(0)
        known = (given[:, 1:] - given[:, :-1]).square().sum(0)
        for step in steps[steps > 1e-6]:
            assert (known - step).abs().min() < 0.05 * known.max()  # a line begins as lines of the exemplar do


def test_lines_that_look_the_same_stand_in_for_each_other():
    image = tartan(100, 110)
    one, other = places(image, (200, 200)), places(image, (200, 200), seed=1)
    assert torch.equal(look_up(image, one), look_up(image, other))
    moved = (one[0, :, 0] != other[0, :, 0]).float().mean()
    assert 0.3 < moved < 1
    stretches = 1 + ((one[0, 1:, 0] - one[0, :-1, 0]) != 1).sum()
    assert 12 < stretches < 60  # eight lines each, or as many as a band has


def test_where_no_line_looks_like_another_each_is_shown_in_turn():
    where = places(tartan(100, 110, grain=0.06), (200, 200))
    assert torch.equal(where[0, 48:], where[0, :-48])
    assert torch.equal(where[1, :, 48:], where[1, :, :-48])


@pytest.mark.parametrize("wraps", [(True, True), (True, False)])
def test_what_wraps_has_whole_cells(wraps):
    image = tartan(100, 110)
    assert torch.equal(continued(image, (96, 144), wraps).roll(48, 1), continued(image, (96, 144), wraps))
    squeezed = continued(image, (90, 144), wraps)
    steps = (squeezed[:, :, 0] - squeezed[:, :, 0].roll(1, 1)).abs().sum(0)
    assert int((steps > 0).sum()) == 2 * 6  # each cell has all bands, the first after the last
    assert places(image, (30, 144), wraps) is None


def other(name: str) -> Exemplar:
    y, x = torch.meshgrid(torch.arange(96), torch.arange(96), indexing="ij")
    image = tartan(96, 96)
    images = {
        "ramp": (y / 96 + x / 96)[None] / 2,
        "stripes": tartan(96, 1).expand(3, 96, 96),
        "one color": torch.full((3, 96, 96), 0.5),
        "noise": torch.rand(3, 96, 96, generator=torch.Generator().manual_seed(0)),
        "discs": ((y % 24 - 12) ** 2 + (x % 24 - 12) ** 2 < 80).float()[None],
        "oblique": image[:, (y + x // 3) % 96, x],
    }
    if name == "two":
        return Exemplar.of([image, image])
    if name == "hole":
        return Exemplar.of(image, masks=[(y - 40).square() + (x - 40).square() > 60])
    if name == "video":
        return Exemplar.of(image[:, None].repeat(1, 5, 1, 1))
    return Exemplar.of(images[name].contiguous())


@pytest.mark.parametrize("name", ["ramp", "stripes", "one color", "noise", "discs", "oblique", "two", "hole", "video"])
def test_what_is_no_cloth(name):
    assert find_weave(other(name)) is None


@pytest.mark.parametrize("name", ["tartan", "ramp", "noise", "discs", "oblique"])
def test_a_large_picture_is_cloth_if_it_is_so_at_full_resolution_and_at_half(name, monkeypatch):
    exemplar = Exemplar.of(tartan(96, 96)) if name == "tartan" else other(name)
    here = find_weave(exemplar)
    monkeypatch.setattr(woven, "LOOKED_AT", 96**2 - 1)
    seen = []
    monkeypatch.setattr(woven, "_lines", lambda one: seen.append(one.shape) or _lines(one))
    again = find_weave(Exemplar.of(exemplar.canvas.clone()))
    assert (here is None) == (again is None) == (name != "tartan")
    assert seen == ([(48, 48), (96, 96)] if name in ("tartan", "ramp") else [(48, 48)])
    if here is not None:
        assert here.cells == again.cells


def test_a_lattice_is_believed_if_it_is_regular_or_lines_are_in_step():
    weave = Weave((Cell(0, 48), Cell(3, 30)), (torch.ones(1, 1), torch.ones(1, 1)))
    assert in_step(weave, Lattice(torch.tensor([[16.2, 0.0], [0.0, 15.0]], dtype=torch.float64), 0.6))
    assert not in_step(weave, Lattice(torch.tensor([[13.0, 0.0], [0.0, 15.0]], dtype=torch.float64), 0.6))
    assert not in_step(weave, Lattice(torch.tensor([[16.0, 0.0], [0.0, 22.0]], dtype=torch.float64), 0.77))
    assert in_step(weave, Lattice(torch.tensor([[13.0, 0.0], [0.0, 22.0]], dtype=torch.float64), 0.8))


def test_lines_are_found_beside_holes_by_least_squares():
    image, known = tartan(12, 15, grain=0.05), torch.ones(12, 15, dtype=torch.bool)
    known[3:8, 4:9], known[0, 10:] = False, False
    rows, columns = lines_through(torch.where(known, image, 9.0), known)
    y, x = known.nonzero().T
    design = torch.cat([torch.eye(12)[y], torch.eye(15)[x]], 1).double()
    for channel in range(3):
        best = torch.linalg.lstsq(design, image[channel, known].double()[:, None], driver="gelsd").solution[:, 0]
        told, meant = rows[channel, :, None] + columns[channel], best[:12, None] + best[12:]
        assert torch.allclose(told, meant, atol=1e-4)


def test_nothing_is_told_of_a_line_of_which_nothing_is_known():
    known = torch.ones(60, 60, dtype=torch.bool)
    known[10] = False
    assert lines_through(tartan(60, 60), known) is None
    assert lines_through(tartan(60, 60), known.T) is None
