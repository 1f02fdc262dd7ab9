import numpy as np
import pytest
import torch
from discs import discs
from exemplars import pebbles
from made import MADE
from scipy import ndimage

from kwatra import Exemplar
from kwatra.elements import find_ground, middle_of
from kwatra.elements.size import element_size
from kwatra.elements.splits import MIXED, PLAIN


@pytest.mark.parametrize("size", [16, 32])
@pytest.mark.parametrize("name", ["stones", "mosaic", "coins", "tiles"])
def test_the_ground_between_elements_is_found(name, size):
    made = MADE[name](128, size, 1)
    truth, found = made.numbers.numpy() == 0, find_ground(Exemplar.of(made.image))
    assert found.sure > 0.9
    assert found.plain > 0.9
    # no element holds ground, but at its shaded rim, and there is a way around each
    inside = ndimage.distance_transform_edt(~truth)
    assert (found.depth[inside > 0.15 * size] > 0).mean() > 0.97
    assert (ndimage.distance_transform_edt(found.depth > 0)[truth] <= 0.2 * size).mean() > 0.9
    assert found.depth[inside > 0.35 * size].min() > 0.5


@pytest.mark.parametrize(("size", "seed"), [(16, 0), (16, 1), (20, 0), (20, 2)])
def test_thin_mortar_of_one_color_is_found_without_the_rims_of_bricks(size, seed):
    """Of the splits that are tried first one has it in parts, and the next takes the rims of bricks for it, too."""
    made = MADE["courses"](128, size, seed)
    truth, found = made.numbers.numpy() == 0, find_ground(Exemplar.of(made.image))
    assert (found.sure, found.plain) == (pytest.approx(1, abs=0.05), 1)
    assert 2 * (truth & (found.depth == 0)).sum() > 0.98 * (truth.sum() + (found.depth == 0).sum())


@pytest.mark.parametrize(("size", "seed"), [(26, 5), (32, 0)])
def test_thin_joints_of_a_color_that_is_not_frequent_are_found(size: int, seed: int) -> None:
    """Stones of one color, with the joints, are taken for the ground else."""
    made = MADE["mosaic"](128, size, seed)
    found = find_ground(Exemplar.of(made.image)).depth == 0
    truth = made.numbers.numpy() == 0
    assert found[~truth].mean() < 0.02
    assert found[truth].mean() > 0.4


@pytest.mark.parametrize("seed", [0, 1])
def test_cloth_is_ground_whatever_the_discs_on_it_are_made_up_of(seed: int) -> None:
    """Their rings are taken for the elements at first."""
    rng, (down, right) = np.random.default_rng(seed), np.mgrid[:128, :128]
    image, truth = np.full((3, 128, 128), 0.4) + rng.normal(0, 0.01, (3, 128, 128)), np.ones((128, 128), bool)
    for row, column in np.argwhere(np.ones((6, 6))) * 24 + rng.uniform(-2, 2, (36, 2)):
        off = np.hypot(down - row, right - column)
        color, on = rng.uniform(0.4, 1, (3, 1)), off < 10
        image[:, on] = color * (0.6 + 0.4 * np.cos(2 * np.pi * off / 5))[on]
        truth &= ~on
    exemplar = Exemplar.of(torch.from_numpy(image).float())
    assert element_size(exemplar) < 8
    found = find_ground(exemplar)
    assert found.hides > 0.9
    assert 18 < found.size < 28
    assert ((found.depth == 0) == truth).mean() > 0.95


def told_apart(parts: np.ndarray, numbers: np.ndarray) -> float:
    """The share of the area of elements, by their numbers, of which a part holds four fifths, and little else."""
    shared = np.zeros((numbers.max() + 1, parts.max() + 1))
    np.add.at(shared, (numbers.ravel(), parts.ravel()), 1)
    shared = shared[1:, 1:]
    most = shared.argmax(1)
    held = shared[np.arange(len(shared)), most]
    one = (held > 0.8 * shared.sum(1)) & (held > 0.8 * shared.sum(0)[most])
    return float(shared[one].sum() / shared.sum())


@pytest.mark.parametrize("size", [16, 20, 26, 32])
@pytest.mark.parametrize("light", [False, True])
def test_shaded_joints_of_stones_of_many_brightnesses_are_found_and_hide_seams(size: int, light: bool) -> None:
    """What is as dark as the joints of light stones is within dark ones."""
    made = MADE["rubble"](128, size, 1)
    found = find_ground(Exemplar.of(1 - made.image if light else made.image))
    assert found.hides > 0.9
    assert told_apart(ndimage.label(found.depth > 0)[0], made.numbers.numpy()) > 0.88


def test_mixed_ground_hides_no_seams_where_elements_are_of_one_color(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("kwatra.elements.ground.nets_of_lines", lambda picture: iter(()))
    assert find_ground(Exemplar.of(MADE["bricks"](128, 24, 1).image)).hides == 0


@pytest.mark.parametrize("side", [96, 128, 160, 192])
def test_of_ways_that_tell_the_ground_as_surely_the_least_is_taken(side):
    """Stones are darker towards their lower right: some splits take that for ground, which is then not plain."""
    found = find_ground(Exemplar.of(pebbles(side)))
    assert found.plain > 0.9
    assert (found.depth == 0).mean() < 0.35


@pytest.mark.parametrize("name", ["stones", "coins"])
def test_light_and_dark_may_trade_places(name):
    image = MADE[name](128, 24, 2).image
    light, dark = find_ground(Exemplar.of(image)), find_ground(Exemplar.of(1 - image))
    assert light.sure == pytest.approx(dark.sure, abs=0.05)
    assert np.abs(light.depth - dark.depth).mean() < 0.02


@pytest.mark.parametrize("ways", [{"mirror": True}, {"rotate": (90.0, 30.0)}, {"scale": (0.8,)}])
def test_ground_hangs_together_within_each_image_alone(ways):
    image = MADE["stones"](128, 24, 1).image
    alone, several = find_ground(Exemplar.of(image)), find_ground(Exemplar.of(image, **ways))
    assert several.sure == pytest.approx(alone.sure, abs=0.01)
    assert (several.depth[:128, :128] == 0).mean() == pytest.approx((alone.depth == 0).mean(), abs=0.07)
    two = find_ground(Exemplar.of([image, MADE["stones"](96, 24, 2).image]))
    assert two.sure == pytest.approx(alone.sure, abs=0.01)


def test_what_is_transparent_between_elements_is_plain_ground():
    """Of gaps one pixel wide what is as dark as they are when smoothed is opaque for the most part."""
    line, generator = torch.arange(90) % 15 > 0, torch.Generator().manual_seed(0)
    opaque = (line[:, None] & line).float()
    colors = torch.rand(3, 6, 6, generator=generator).repeat_interleave(15, 1).repeat_interleave(15, 2)
    cells = 0.3 + 0.3 * colors + 0.4 * torch.rand(3, 90, 90, generator=generator)
    cut_out = torch.cat([cells * opaque, opaque[None]])
    found = find_ground(Exemplar.of(cut_out))
    assert found.sure > 0.9
    assert found.plain == 1
    assert np.array_equal(found.depth == 0, opaque.numpy() == 0)
    gray = torch.cat([cells[:1], opaque[None]]), cells[:1]  # whose last is alpha, and is none
    assert [find_ground(Exemplar.of(image)).plain > 0.5 for image in gray] == [True, False]


@pytest.mark.parametrize("thin", [1, 3])
@pytest.mark.parametrize("gray", [0.3, 0.55])
def test_ground_as_bright_as_elements_is_told_by_its_color(gray, thin):
    rng, side, cell = np.random.default_rng(0), 126, 18
    palette = np.array([[0.2, 0.4, 0.7], [0.9, 0.8, 0.2], [0.8, 0.2, 0.3], [0.2, 0.6, 0.4]])
    colors = palette[rng.integers(4, size=(7, 7))].repeat(cell, 0).repeat(cell, 1)
    line = np.arange(side) % cell >= thin
    stone = line[:, None] & line
    image = np.where(stone[..., None], colors, gray) + rng.normal(0, 0.02, (side, side, 1))
    found = find_ground(Exemplar.of(torch.from_numpy(image).float().movedim(-1, 0)))
    assert found.sure > 0.9
    assert found.plain == 1
    truth, here = ~stone, found.depth == 0
    assert (truth & here).sum() > 0.9 * max(truth.sum(), here.sum())


@pytest.mark.parametrize(("size", "seed"), [(16, 1), (20, 0), (24, 0)])
@pytest.mark.parametrize("grain", [0.0, 0.005])
def test_ground_is_all_of_it_that_is_wide(size: int, seed: int, grain: float) -> None:
    """What is right around rows of letters is surely ground, too; but much of the page is left to large parts."""
    made = MADE["letters"](128, size, seed)
    noise = grain * torch.randn(made.image.shape, generator=torch.Generator().manual_seed(0))
    found = find_ground(Exemplar.of((made.image + noise).clamp(0, 1)))
    away = ndimage.distance_transform_edt(made.numbers.numpy() == 0)
    assert found.hides > 0.5
    assert (found.depth[away > 0.2 * size] == 0).mean() > 0.95


def test_ground_in_parts_is_less_sure():
    """Of discs in two halves, a wide wall between them, the ground hangs together but for half of it."""
    image = MADE["coins"](128, 24, 2).image.clone()
    whole = find_ground(Exemplar.of(image)).sure
    image[:, :, 60:68] = image.flatten(1).amax(1)[:, None, None]
    assert find_ground(Exemplar.of(image)).sure < 0.7 * whole


def test_ground_of_several_colors_is_not_plain():
    ground = MADE["coins"](128, 24, 0).numbers == 0
    red = torch.arange(128).expand(128, 128) / 127
    for share in (0.5, 0.6, 0.7, 1.0):
        colors = torch.stack([0.5 + share * (red - 0.5), torch.zeros(128, 128), 0.5 - share * (red - 0.5)])
        image = torch.where(ground, colors, 0.8)
        found = find_ground(Exemplar.of(image))
        here = torch.from_numpy(found.depth == 0)
        part = sum(c[here].var(correction=0) for c in image) / sum(c.var(correction=0) for c in image)
        assert found.plain == pytest.approx(float(((MIXED - part) / (MIXED - PLAIN)).clamp(0, 1)), abs=1e-4)
    assert found.plain == 0


@pytest.mark.parametrize("share", [0.7, 1.0])
def test_what_is_of_one_color_has_no_ground(share):
    flat, mask = torch.full((3, 32, 32), 1 / 3), torch.rand(32, 32, generator=torch.Generator().manual_seed(0)) < share
    assert find_ground(Exemplar.of(flat, masks=[mask])).sure == 0


@pytest.mark.parametrize("seed", range(3))
def test_noise_has_no_ground(seed):
    noise = np.random.default_rng(seed).normal(size=(3, 128, 128))
    smooth = ndimage.gaussian_filter(noise, (0, 3, 3))
    for image in (noise, smooth):
        assert find_ground(Exemplar.of(torch.from_numpy(image).float())).sure < 0.5


def test_one_color_has_no_ground():
    found = find_ground(Exemplar.of(torch.full((3, 32, 40), 0.5)))
    assert found.sure == 0
    assert found.depth.shape == (32, 40)


def test_what_nobody_owns_is_no_ground():
    made = MADE["coins"](128, 24, 0)
    mask = torch.ones(128, 128, dtype=torch.bool)
    mask[:50, :50] = False
    image = torch.where(mask, made.image, 0.0)  # as black as the cloth
    found = find_ground(Exemplar.of([image], masks=[mask]))
    assert found.sure > 0.8
    assert found.depth[:45, :45].min() > 0


def test_what_a_hole_holds_has_no_influence():
    image = MADE["stones"](96, 24, 0).image
    hole = torch.ones(96, 96, dtype=torch.bool)
    hole[30:50, 40:70] = False
    grounds = [find_ground(Exemplar.of(torch.where(hole, image, value), masks=[hole])) for value in (0.0, 1.0)]
    assert grounds[0].sure == grounds[1].sure > 0.2
    assert np.array_equal(grounds[0].depth, grounds[1].depth)


def test_what_a_hole_leaves_of_an_element_is_no_ground_and_specks_are() -> None:
    image, number = discs(6, 6, 2, 0.02)
    disc = number == 15
    rows, columns = (slice(line.min(), line.max() + 1) for line in np.nonzero(disc))
    hole = np.zeros(number.shape, bool)
    hole[rows.start - 4 : rows.stop - 2, columns.start - 6 : columns.stop + 6] = True
    left = disc & ~hole
    assert 4 <= left.sum() < 0.04 * 26**2
    depth = find_ground(Exemplar.of([image], masks=[torch.from_numpy(~hole)])).depth
    assert (depth[left] > 0).mean() > 0.7
    image[:, left] = 0.1 + 0.02 * torch.randn(3, int(left.sum()), generator=torch.Generator().manual_seed(0))
    assert not find_ground(Exemplar.of([image], masks=[torch.from_numpy(~hole)])).depth[left].any()


def test_the_middle_of_colors_is_their_median_whatever_a_few_are() -> None:
    middle, spread = middle_of(np.array([[1.0, 2.0, 3.0, 4.0, 100.0], [5.0, 5.0, 5.0, 5.0, -9.0]]))
    assert middle.tolist() == [3.0, 5.0]
    assert spread.tolist() == [1.0, 0.0]


@pytest.mark.filterwarnings("error")
def test_where_all_ground_is_what_was_taken_for_specks_nothing_is_told_of_its_color() -> None:
    tones = ["2...9", "16.5.", ".1379", ".3.79", "5729."]  # where it may be copied from
    z = torch.tensor([[[0.0 if tone == "." else int(tone) / 10 for tone in row] for row in tones]])
    found = find_ground(Exemplar.of(z, masks=[torch.tensor([[tone != "." for tone in row] for row in tones])]))
    assert np.isfinite(found.depth).all()
    assert 0 <= found.sure <= 1
