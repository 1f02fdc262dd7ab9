import pytest
import torch
from torch.utils._python_dispatch import TorchDispatchMode

from kwatra import InputError
from kwatra.windows.grid import Grid, channels_last, step_of, windows_at

GRIDS = [
    ((37, 41), (8, 8), False),
    ((37, 41), (8, 8), True),
    ((33, 30), (10, 6), False),
    ((9, 20, 17), (4, 8, 8), False),
    ((9, 20, 17), (4, 8, 8), True),
    ((10, 10), (8, 8), True),
]


def grid_of(shape, width, wrap):
    return Grid(shape, width, tuple(map(step_of, width)), wrap)


@pytest.mark.parametrize(("shape", "width", "wrap"), GRIDS)
@pytest.mark.parametrize("channels", [1, 3, 5])
def test_scatter_is_the_exact_transpose_of_gather(shape, width, wrap, channels):
    grid, generator = grid_of(shape, width, wrap), torch.Generator().manual_seed(1)
    x = torch.rand(channels, *shape, dtype=torch.float64, generator=generator)
    v = torch.rand(len(grid), *width, channels, dtype=torch.float64, generator=generator)
    assert torch.isclose((grid.gather(x) * v).sum(), (x * grid.scatter(v)).sum(), rtol=1e-12)


@pytest.mark.parametrize(("shape", "width", "wrap"), GRIDS)
def test_every_pixel_is_covered(shape, width, wrap):
    grid = grid_of(shape, width, wrap)
    count = grid.scatter(torch.ones(len(grid), *width, 1))
    assert count.min() >= 1
    if wrap and all(s % t == 0 for s, t in zip(shape, grid.step, strict=True)):
        assert count.min() == count.max()


@pytest.mark.parametrize(("shape", "width", "wrap"), GRIDS)
def test_windows_hold_the_pixels_they_stand_on(shape, width, wrap):
    grid = grid_of(shape, width, wrap)
    axes = torch.meshgrid(*(torch.arange(s) for s in shape), indexing="ij")
    windows = grid.gather(torch.stack(axes).double())
    for corner, window in zip(grid.corners[::7], windows[::7], strict=True):
        first = window[(0,) * len(shape)]
        last = window[(-1,) * len(shape)]
        size = torch.tensor(shape)
        assert torch.equal(first.long(), corner)
        assert torch.equal(last.long(), (corner + torch.tensor(width) - 1) % size)


@pytest.mark.parametrize(("shape", "width", "wrap"), GRIDS)
def test_bands_add_up_to_the_whole(shape, width, wrap):
    grid, generator = grid_of(shape, width, wrap), torch.Generator().manual_seed(0)
    v = torch.rand(len(grid), *width, 2, dtype=torch.float64, generator=generator)
    x = torch.rand(2, *shape, dtype=torch.float64, generator=generator)
    total, first, bands = x.clone(), 0, list(grid.bands(2 * len(grid) // grid.counts[0]))
    for band in bands:
        part = slice(first, first + len(band))
        assert torch.equal(band.gather(x), grid.gather(x)[part])
        assert band.scatter(v[part], total) is total
        first += len(band)
    assert first == len(grid)
    assert len(bands) > 1
    assert torch.allclose(total, x + grid.scatter(v))


class Largest(TorchDispatchMode):
    """Notes the size of the largest tensor that any operation made or wrote to."""

    size = 0

    def __torch_dispatch__(self, func, types, args=(), kwargs=None):
        out = func(*args, **(kwargs or {}))
        if isinstance(out, torch.Tensor):
            self.size = max(self.size, out.numel())
        return out


@pytest.mark.parametrize("wrap", [False, True])
def test_the_work_of_a_band_does_not_grow_with_the_image(wrap):
    image = torch.rand(3, 4000, 40)
    bands = list(grid_of((4000, 40), (8, 8), wrap).bands(100))
    for band in (bands[0], bands[70], bands[-1]):
        with Largest() as largest:
            windows = band.gather(image)
            band.scatter(windows, image)
        assert largest.size <= 2 * windows.numel()


@pytest.mark.parametrize("wrap", [False, True])
def test_what_covers_a_long_line_takes_no_more_than_the_line(wrap):
    with Largest() as largest:
        window, inside, _ = grid_of((8, 5000), (8, 8), wrap).covering(1)
    assert largest.size <= 2 * window.numel() == 2 * 5000 * 4
    assert torch.equal((2 * window + inside) % 5000, torch.arange(5000)[:, None].expand(-1, 4))


def test_shifting_a_periodic_image_by_a_step_permutes_its_windows():
    grid = grid_of((32, 24), (8, 8), True)
    x = torch.rand(1, 32, 24, generator=torch.Generator().manual_seed(0))
    windows = grid.gather(x).view(*grid.counts, -1)
    shifted = grid.gather(x.roll((2, 4), (1, 2))).view(*grid.counts, -1)
    assert torch.equal(shifted, windows.roll((1, 2), (0, 1)))


@pytest.mark.parametrize("wrap", [False, True])
def test_neighbors_of_a_shifted_copy_predict_each_other(wrap):
    grid = grid_of((24, 28), (8, 8), wrap)
    for there, shift in grid.neighbor_shifts():
        moved = grid.corners[there] + shift
        if wrap:
            moved = moved % torch.tensor(grid.shape)
        assert torch.equal(moved, grid.corners)
        assert shift.abs().max() <= 4


@pytest.mark.parametrize("layout", [grid_of((24, 28), (8, 8), (True, False)), grid_of((10, 12, 9), (4, 4, 4), False)])
def test_neighbors_of_a_part_are_those_of_the_whole(layout):
    part = slice(len(layout) // 3, len(layout) - 2)
    for (some, moved), (there, shift) in zip(layout.neighbor_shifts(part), layout.neighbor_shifts(), strict=True):
        assert torch.equal(some, there[part])
        assert torch.equal(moved, shift[part])


def test_neighbors_of_a_window_inside_a_grid_lie_one_step_away_on_either_side():
    grid = grid_of((24, 28), (8, 8), False)
    columns = grid.counts[1]
    middle = columns + 1
    assert [int(there[middle]) for there, _ in grid.neighbor_shifts()] == [1, 1 + 2 * columns, columns, columns + 2]


def test_windows_at_agrees_with_slicing():
    image = torch.rand(3, 9, 12, 11, generator=torch.Generator().manual_seed(0))
    corners = torch.tensor([[0, 0, 0], [5, 3, 2], [2, 8, 7]])
    windows = windows_at(channels_last(image), corners, (4, 4, 4))
    for (t, y, x), window in zip(corners.tolist(), windows, strict=True):
        assert torch.equal(window.movedim(-1, 0), image[:, t : t + 4, y : y + 4, x : x + 4])


def test_a_step_that_leaves_gaps_between_windows_is_refused():
    with pytest.raises(InputError, match="does not divide the window width"):
        Grid((20, 20), (8, 8), (3, 3))
    with pytest.raises(InputError, match="choose smaller windows"):
        Grid((20, 6), (8, 8), (2, 2))


@pytest.mark.parametrize(("width", "step"), [(32, 8), (16, 4), (8, 2), (4, 1), (6, 1), (12, 3), (2, 1)])
def test_step_is_a_quarter_of_the_width_where_it_divides(width, step):
    assert step_of(width) == step
