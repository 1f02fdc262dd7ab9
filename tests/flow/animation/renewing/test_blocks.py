"""The block search: finds what was cut out, to the pixel, by what is known of it alone."""

import pytest
import torch
import torch.nn.functional as F
from torch import Tensor

import flow
from flow.animation.film.film import Film
from flow.animation.renewing.blocks import Blocks
from flow.warps.warp import pixel_coordinates
from kwatra import Exemplar, InputError

SIZE = 16


def smooth(height: int = 60, width: int = 70, channels: int = 2, seed: int = 0) -> Tensor:
    """Noise without detail finer than some pixels, so that it can be read between pixels."""
    noise = torch.rand(channels, height, width, generator=torch.Generator().manual_seed(seed))
    return F.avg_pool2d(F.pad(noise[None], (4, 4, 4, 4), mode="reflect"), 5, 1)[0][:, 2:-2, 2:-2]


def generator() -> torch.Generator:
    return torch.Generator().manual_seed(0)


def cut(image: Tensor, x: float, y: float) -> Tensor:
    """The block at (x, y), (1, C, SIZE, SIZE)."""
    places = pixel_coordinates((SIZE, SIZE)) + torch.tensor([x, y]).view(2, 1, 1)
    return flow.warp(image, places, "lanczos")[None]


def nearest(exemplar: Exemplar, content: Tensor, known: Tensor | None = None, used: Tensor | None = None) -> Tensor:
    known = torch.ones(len(content), 1, SIZE, SIZE) if known is None else known
    used = torch.zeros(exemplar.shape) if used is None else used
    return Blocks(Film.of(exemplar), (SIZE, SIZE)).nearest(content, known, lambda rows: used[rows], generator())


@pytest.mark.parametrize("place", [(0, 0), (54, 44), (53, 43), (13, 22), (30, 7)])
def test_a_block_of_the_exemplar_is_found_where_it_was_cut(place: tuple[int, int]) -> None:
    image = smooth()
    found = nearest(Exemplar.of(image), cut(image, *map(float, place)))
    assert float((found - torch.tensor(place)).abs().max()) < 0.02


@pytest.mark.parametrize("place", [(20.5, 31.0), (7.0, 12.5), (33.5, 20.5), (15.25, 9.75)])
def test_what_lies_between_pixels_is_found_beside_them(place: tuple[float, float]) -> None:
    image = smooth()
    found = nearest(Exemplar.of(image), cut(image, *place))
    assert found.dtype == torch.long
    assert float((found - torch.tensor(place)).abs().max()) <= 0.5


def test_several_blocks_are_found_at_once_in_their_order() -> None:
    image = smooth()
    places = [(40.0, 3.0), (2.0, 30.0), (19.0, 19.0)]
    found = nearest(Exemplar.of(image), torch.cat([cut(image, *place) for place in places]))
    assert float((found - torch.tensor(places)).abs().max()) < 0.02


def test_the_best_of_all_places_is_found() -> None:
    """Against the sum of squared differences, place by place: at most a little is lost to the coarse search."""
    image, content = smooth(), smooth(SIZE, SIZE, seed=5)[None]
    weight = torch.rand(1, 1, SIZE, SIZE, generator=torch.Generator().manual_seed(2))
    windows = image.unfold(1, SIZE, 1).unfold(2, SIZE, 1)
    cost = ((windows - content[0, :, None, None]).square() * weight[0, :, None]).sum((0, 3, 4))
    x, y = nearest(Exemplar.of(image), content, weight)[0].round().long().tolist()
    assert float(cost[y, x]) <= 1.05 * float(cost.min())
    assert float(cost[y, x]) < 0.7 * float(cost.median())


def test_unknown_pixels_have_no_influence() -> None:
    image = smooth()
    content, known = cut(image, 25.0, 14.0), torch.ones(1, 1, SIZE, SIZE)
    known[..., 9:] = 0
    found = nearest(Exemplar.of(image), content, known)
    spoiled = torch.where(known > 0, content, 100.0)
    assert torch.equal(nearest(Exemplar.of(image), spoiled, known), found)
    assert float((found - torch.tensor([25.0, 14.0])).abs().max()) < 0.1


def test_of_equal_blocks_the_unused_one_is_taken() -> None:
    image = smooth(40, 80)
    image[:, :, 40:] = image[:, :, :40]
    used = torch.zeros(40, 80)
    for side, expected in ((slice(None, 40), 50.0), (slice(40, None), 10.0)):
        used.zero_()
        used[:, side] = 0.01
        found = nearest(Exemplar.of(image), cut(image, 10.0, 12.0), used=used)
        assert float((found - torch.tensor([expected, 12.0])).abs().max()) < 0.05


def test_no_block_crosses_a_hole_or_leaves_its_image() -> None:
    """Wherever the content was cut, all pixels that the found block reads belong to one image."""
    first, second = smooth(40, 50), smooth(36, 44, seed=1)
    hole = torch.ones(40, 50, dtype=torch.bool)
    hole[18:24, 20:27] = False
    exemplar = Exemplar.of([first, second], masks=[hole, None])
    places = torch.rand(60, 2, generator=generator()) * torch.tensor([33.9, 60.0])
    places[0] = torch.tensor([20 - SIZE + 0.45, 18 - SIZE + 0.45])  # reads one corner of the hole
    canvas = flow.filled(exemplar.canvas, exemplar.owner >= 0)
    found = nearest(exemplar, torch.cat([cut(canvas, *place.tolist()) for place in places]))
    for x, y in found.tolist():
        read = exemplar.owner[int(y) : int(-(-y // 1)) + SIZE, int(x) : int(-(-x // 1)) + SIZE]
        assert read.shape[0] >= SIZE
        assert read.shape[1] >= SIZE
        assert float(read.min()) == float(read.max()) >= 0


def test_what_a_hole_holds_has_no_influence() -> None:
    image, hole = smooth(), torch.ones(60, 70, dtype=torch.bool)
    hole[20:31, 30:41] = False
    content = torch.cat([cut(image, x, y) for x, y in ((11.0, 17.0), (43.5, 20.0), (25.0, 25.0))])
    found = [nearest(Exemplar.of(torch.where(hole, image, value), masks=[hole]), content) for value in (0.0, 0.4, 1.0)]
    assert torch.equal(found[0], found[1])
    assert torch.equal(found[0], found[2])


def test_a_block_of_which_nothing_is_known_comes_from_anywhere_usable() -> None:
    image, hole = smooth(), torch.ones(60, 70, dtype=torch.bool)
    hole[:, 35:] = False
    found = nearest(Exemplar.of(image, masks=[hole]), torch.zeros(200, 2, SIZE, SIZE), torch.zeros(200, 1, SIZE, SIZE))
    assert float(found.min()) >= 0
    assert float(found[:, 0].max()) == 35 - SIZE
    assert float(found[:, 1].max()) > 60 - SIZE - 4
    assert len(found.unique(dim=0)) > 100


def test_channels_without_weight_do_not_count() -> None:
    image = smooth()
    content = cut(image, 31.0, 9.0)
    content[:, 1] = 5.0
    found = nearest(Exemplar.of(image, weights=[1.0, 0.0]), content)
    assert float((found - torch.tensor([31.0, 9.0])).abs().max()) < 0.02


def test_blocks_shrink_until_they_fit() -> None:
    assert Blocks(Film.of(Exemplar.of(smooth(24, 24))), (48, 48)).sides == (24, 24)
    assert Blocks(Film.of(Exemplar.of(smooth(23, 40))), (48, 48)).sides == (12, 12)
    blocks = Blocks(Film.of(Exemplar.of(smooth(9, 9))), (15, 15))  # odd, so without a coarse search
    assert blocks.sides == (7, 7)
    content = smooth(9, 9)[None, :, 1:8, 2:9]
    found = blocks.nearest(content, torch.ones(1, 1, 7, 7), lambda rows: torch.zeros(len(rows), 9), generator())
    assert torch.equal(found, torch.tensor([[2.0, 1.0]]))
    holes = torch.zeros(9, 9, dtype=torch.bool)
    holes[::2, ::2] = True
    with pytest.raises(InputError, match="no 2x2 block fits into the exemplar; its mask leaves too little"):
        Blocks(Film.of(Exemplar.of(smooth(9, 9), masks=[holes])), (15, 15))


def test_of_blocks_that_agree_as_well_the_one_near_its_home_is_found_whatever_its_frame() -> None:
    image = smooth(40, 40).repeat(1, 2, 2)
    clip = Film.of(Exemplar.of(image[:, None].repeat(1, 6, 1, 1)))
    content = clip.described.canvas[:, 8:24, 12:28][None]
    known, unused = torch.ones(1, 1, SIZE, SIZE), lambda rows: torch.zeros(len(rows), 80)
    for x in (12, 52):
        for y in (8, 48):
            home = [torch.tensor([x + 9.0, y - 7.0])]
            found = Blocks(clip, (SIZE, SIZE)).nearest(content, known, unused, generator(), home)[0]
            assert found[0] == x
            assert found[1] % clip.pitch == y
    odd = content + torch.where(torch.arange(SIZE) < 8, 0.0, 0.05)
    assert Blocks(clip, (SIZE, SIZE)).nearest(odd, known, unused, generator(), [torch.tensor([52.0, 8.0])])[0, 0] == 52
