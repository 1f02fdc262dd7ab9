import torch

from kwatra import Exemplar
from kwatra.source import sourcemap
from kwatra.source.canvas import SourceWindows
from kwatra.windows.grid import Grid


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def setting(wrap=False):
    source = SourceWindows(Exemplar.of(torch.rand(1, 30, 34, generator=generator())), (8, 8), generator())
    grid = Grid((21, 26), (8, 8), (2, 2), wrap)
    pick = torch.randint(len(source.numbers), (len(grid),), generator=generator(1))
    return source, grid, source.numbers[pick], torch.rand(len(grid), generator=generator(2))


def test_each_pixel_comes_from_its_heaviest_window():
    for wrap in (False, True):
        source, grid, matches, weights = setting(wrap)
        where = sourcemap.winners(grid, source, matches, weights)
        for y, x in [(0, 0), (20, 25), (7, 3), (11, 19)]:
            best, expected = -1.0, None
            for corner, match, weight in zip(grid.corners, source.corners(matches), weights, strict=True):
                inside = torch.tensor([y, x]) - corner
                inside = inside % torch.tensor(grid.shape) if wrap else inside
                if bool((inside >= 0).all() and (inside < 8).all()):
                    share = float(weight * source.metric.falloff[tuple(inside)])
                    if share > best * (1 + 1e-5):
                        best, expected = share, match + inside
            assert where[:, y, x].tolist() == expected.tolist()


def test_a_shifted_copy_keeps_its_offset_through_all_resolutions():
    axes = torch.meshgrid(torch.arange(12), torch.arange(10), indexing="ij")
    where = torch.stack(axes) + torch.tensor([3, 5]).view(2, 1, 1)
    fine = sourcemap.carried(where, (4, 4), (1, 1), (46, 40))
    full = torch.stack(torch.meshgrid(torch.arange(46), torch.arange(40), indexing="ij"))
    assert torch.equal(fine - full, torch.tensor([12, 20]).view(2, 1, 1).expand(2, 46, 40))
    assert torch.equal(sourcemap.carried(fine, (1, 1), (4, 4), (11, 10)), where[:, :11])
    assert torch.equal(sourcemap.carried(fine, (1, 1), (1, 1), (46, 40)), fine)


def test_windows_of_a_map_are_those_it_points_to():
    source, grid, _, _ = setting()
    full = torch.stack(torch.meshgrid(torch.arange(21), torch.arange(26), indexing="ij"))
    matches = sourcemap.at_windows(grid, source, full + torch.tensor([4, 6]).view(2, 1, 1))
    assert torch.equal(source.corners(matches), grid.corners + torch.tensor([4, 6]))


def test_near_a_joint_in_time_windows_are_of_a_copy_that_lies_within_its_clip():
    source = SourceWindows(Exemplar.of(torch.rand(1, 10, 12, 12, generator=generator())), (4, 4, 4), generator())
    grid = Grid((12, 12, 12), (4, 4, 4), (1, 1, 1))
    where = torch.stack(torch.meshgrid(*[torch.arange(12)] * 3, indexing="ij"))
    where[0] = torch.tensor([4, 5, 6, 7, 8, 9, 3, 4, 5, 6, 7, 8]).view(
        -1, 1, 1
    )  # to the clip's end, and near its begin
    matches = source.corners(sourcemap.at_windows(grid, source, where))
    later = torch.where(grid.corners[:, 0] < 3, 4, -3)  # the first copy's window would begin at 7 there, the last at 6
    assert torch.equal(matches[:, 0], grid.corners[:, 0] + later)
    assert torch.equal(matches[:, 1:], grid.corners[:, 1:])
    where[0] = 0  # of a frame shown all the time no window fits but where it begins: the nearest to its center
    matches = source.corners(sourcemap.at_windows(grid, source, where))
    assert torch.equal(matches[:, 0], torch.zeros_like(matches[:, 0]))


def test_look_up_takes_maps_that_lie_otherwise_in_memory():
    image = torch.rand(2, 5, 6, generator=torch.Generator().manual_seed(0))
    where = torch.stack(torch.meshgrid(torch.arange(5), torch.arange(6), indexing="ij")).transpose(1, 2)
    assert torch.equal(sourcemap.look_up(image, where), image.transpose(1, 2))


def test_look_up_reads_the_canvas():
    image = torch.rand(3, 9, 9, generator=generator())
    where = torch.tensor([[[2, 0]], [[5, 8]]])
    assert torch.equal(sourcemap.look_up(image, where)[:, 0, 1], image[:, 0, 8])


def test_a_window_that_runs_over_the_border_comes_from_what_is_shown_there():
    source, grid, _, _ = setting(True)
    axes = torch.meshgrid(*(torch.arange(n) for n in grid.shape), indexing="ij")
    where = (torch.stack(axes) + 9).roll((9, 11), (1, 2))  # so that the map's own border lies in the middle
    middle = (grid.corners + 4) % torch.tensor(grid.shape)
    expected = source.snapped(where[(slice(None), *middle.T)].T - 4)
    assert bool((grid.corners + 4 >= torch.tensor(grid.shape)).any())
    assert torch.equal(sourcemap.at_windows(grid, source, where), expected)


def test_a_coarser_map_is_that_of_the_middles_of_blocks():
    where = torch.stack(torch.meshgrid(torch.arange(16), torch.arange(12), indexing="ij"))
    where[0, 2::4] += 40  # rows of pixels in the middle of blocks
    coarse = sourcemap.coarser(where, (4, 4), (4, 3))
    rows, columns = torch.meshgrid(torch.arange(4), torch.arange(3), indexing="ij")
    assert torch.equal(coarse, torch.stack([rows + 10, columns]))
