import pytest
import torch

from kwatra import Exemplar, FreeWindows, Grid, InputError, Level, Settings, mean, optimize
from kwatra.step import regular


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def free(wrap=False, shape=(13, 17), width=(4, 6), count=40):
    sides = zip(shape, width, wrap if isinstance(wrap, tuple) else (wrap, wrap), strict=True)
    room = [size if wraps else size - w + 1 for size, w, wraps in sides]
    corners = torch.stack([torch.randint(r, (count,), generator=generator(1)) for r in room], 1)
    return FreeWindows(shape, width, corners, wrap)


def layouts():
    grids = [Grid((13, 17), (4, 6), (2, 3)), Grid((12, 18), (4, 6), (2, 3), wrap=True)]
    return [free(), free(True), *grids, free((True, False)), Grid((13, 17), (4, 6), (2, 3), wrap=(False, True))]


@pytest.mark.parametrize("wrap", [False, True, (True, False)])
def test_gather_reads_windows_where_they_lie(wrap):
    windows = free(wrap)
    image = torch.rand(2, 13, 17, generator=generator())
    there = windows.gather(image)
    for k in (0, 7, 39):
        y, x = windows.corners[k].tolist()
        rows, columns = torch.arange(y, y + 4) % 13, torch.arange(x, x + 6) % 17
        assert torch.equal(there[k], image[:, rows[:, None], columns].movedim(0, -1))


@pytest.mark.parametrize("wrap", [False, True, (True, False), (False, True)])
def test_scatter_is_the_transpose_of_gather(wrap):
    windows = free(wrap)
    x = torch.rand(2, 13, 17, generator=generator(), dtype=torch.float64)
    y = torch.rand(40, 4, 6, 2, generator=generator(2), dtype=torch.float64)
    assert float((windows.gather(x) * y).sum()) == pytest.approx(float((x * windows.scatter(y)).sum()))
    parts = [(band, len(band)) for band in windows.bands(7)]
    assert sum(count for _, count in parts) == 40
    summed = sum(band.scatter(part) for (band, _), part in zip(parts, y.split(7), strict=True))
    assert torch.allclose(summed, windows.scatter(y))


@pytest.mark.parametrize(
    "layout", layouts(), ids=["free", "free, wrapped", "grid", "grid, wrapped", "free, one way", "grid, one way"]
)
def test_coverings_name_every_window_of_every_pixel_once(layout):
    named = set()
    for window, inside, there in layout.coverings():
        window, there, *inside = torch.broadcast_tensors(window, there, *inside)
        for y in range(layout.shape[0]):
            for x in range(layout.shape[1]):
                place = torch.stack([i[y, x] for i in inside])
                assert bool(((place >= 0) & (place < torch.tensor(layout.width))).all())
                if bool(there[y, x]):
                    key = (int(window[y, x]), y, x)
                    assert key not in named
                    named.add(key)
                    lies = (layout.corners[window[y, x]] + place) % torch.tensor(layout.shape)
                    assert lies.tolist() == [y, x]
    assert len(named) == len(layout) * layout.width[0] * layout.width[1]


@pytest.mark.parametrize("threads", [1, 3])
def test_coverings_name_the_windows_of_a_pixel_in_order(threads):
    torch.set_num_threads(threads)  # which share the pixels
    windows = free(True, (24, 25))
    named = [torch.where(there, window, len(windows)) for window, _, there in windows.coverings()]
    rows, columns = ((torch.arange(n)[:, None] - line) % n for n, line in zip((24, 25), windows.corners.T, strict=True))
    covers = (rows < 4)[:, None] & (columns < 6)[None]  # (24, 25, N)
    expected = torch.where(covers, torch.arange(len(windows)), len(windows)).sort(2).values
    assert torch.equal(torch.stack(named, 2), expected[..., : len(named)])
    assert len(named) == int(covers.sum(2).max())


def test_neighbors_are_the_nearest_windows():
    windows = free(count=12)
    neighbors = list(windows.neighbor_shifts())
    assert len(neighbors) == 4
    apart = (windows.corners[:, None] - windows.corners).double().norm(dim=-1)
    apart.fill_diagonal_(torch.inf)
    for k, (number, shift) in enumerate(neighbors):
        assert torch.equal(shift, windows.corners - windows.corners[number])
        assert torch.allclose(shift.double().norm(dim=1), apart.sort(1).values[:, k])
    for (some, moved), (number, shift) in zip(windows.neighbor_shifts(slice(3, 8)), neighbors, strict=True):
        assert torch.equal(some, number[3:8])
        assert torch.equal(moved, shift[3:8])


def test_neighbors_of_a_periodic_image_are_the_nearest_around_its_border():
    shape = torch.tensor([20, 24])
    windows = free(True, (20, 24), count=12)
    apart = (windows.corners[:, None] - windows.corners).abs()
    apart = torch.minimum(apart, shape - apart).double().norm(dim=-1)
    apart.fill_diagonal_(torch.inf)
    for k, (number, shift) in enumerate(windows.neighbor_shifts()):
        assert torch.equal(shift % shape, (windows.corners - windows.corners[number]) % shape)
        assert torch.allclose(shift.double().norm(dim=1), apart.sort(1).values[:, k])


def test_windows_may_move_from_iteration_to_iteration():
    exemplar = Exemplar.of(torch.rand(1, 32, 32, generator=generator()))
    asked, given, voted = [], [], []

    def wandering(step):
        asked.append(step.iteration)
        grid = regular(step)
        room = torch.tensor(step.shape) - torch.tensor(step.width)
        moved = grid.corners + torch.randint(-2, 3, grid.corners.shape, generator=step.generator)
        given.append(FreeWindows(step.shape, step.width, moved.clamp(min=0).minimum(room)))
        return given[-1]

    def vote(ballot):
        voted.append(ballot.layout)
        return mean(ballot)

    settings = Settings(levels=(Level(1, 8, 4),), layout=wandering, vote=vote)
    free = optimize(exemplar, (32, 32), settings=settings)
    assert asked == [0, 1, 2, 3, 4]
    assert all(one is other for one, other in zip(voted, given, strict=True))
    totals = [row["total"] for row in free.energies if row["width"] == 8]
    assert totals[-1] < totals[0]
    # where the image is the exemplar, so it stays wherever windows lie
    same = optimize(exemplar, (32, 32), settings=Settings(layout=wandering), start=exemplar.canvas)
    assert torch.allclose(same.image, exemplar.canvas, atol=1e-3)


def test_a_pixel_that_no_window_covers_keeps_what_it_has():
    exemplar = Exemplar.of(torch.rand(1, 32, 32, generator=generator()))
    corner = torch.zeros(1, 2, dtype=torch.long)
    start = torch.rand(1, 32, 32, generator=generator(3))
    settings = Settings(layout=lambda step: FreeWindows(step.shape, step.width, corner))
    made = optimize(exemplar, (32, 32), settings=settings, start=start).image
    assert torch.allclose(made[:, 20:, 20:], start[:, 20:, 20:], atol=1e-5)
    assert not torch.allclose(made[:, :8, :8], start[:, :8, :8], atol=0.05)


def test_windows_outside_of_the_image_are_refused():
    with pytest.raises(InputError, match="starts outside of an image"):
        FreeWindows((10, 10), (4, 4), torch.tensor([[7, 0]]))
    with pytest.raises(InputError, match="there are 0 windows"):
        FreeWindows((10, 10), (4, 4), torch.zeros(0, 2, dtype=torch.long))


@pytest.mark.parametrize("wrap", [(True, False, False), (False, True, True)])
def test_a_grid_may_be_periodic_along_some_axes(wrap):
    grid = Grid((6, 9, 8), (4, 4, 4), (1, 2, 2), wrap)
    x = torch.rand(2, 6, 9, 8, generator=generator(), dtype=torch.float64)
    y = torch.rand(len(grid), 4, 4, 4, 2, generator=generator(1), dtype=torch.float64)
    assert float((grid.gather(x) * y).sum()) == pytest.approx(float((x * grid.scatter(y)).sum()))
    banded = torch.zeros_like(x)
    first = 0
    for band in grid.bands(9):
        banded = band.scatter(y[first : first + len(band)], banded)
        first += len(band)
    assert torch.allclose(banded, grid.scatter(y))
    for axis, wraps in enumerate(wrap):
        moved = grid.gather(x.roll(2, axis + 1))
        before = grid.gather(x)
        shifted = before.view(*grid.counts, -1).roll(2 // grid.step[axis], axis).view_as(before)
        assert (torch.equal(moved, shifted)) is (wraps and grid.shape[axis] % grid.step[axis] == 0)
    for _, shift in grid.neighbor_shifts():
        assert bool((shift.abs() <= torch.tensor(grid.step)).all())


def test_an_answer_for_each_axis_or_one_for_all():
    with pytest.raises(InputError, match=r"wrap is \(True, False, True\); give one answer for all 2 axes, or 2"):
        len(Grid((9, 9), (4, 4), (2, 2), (True, False, True)))
