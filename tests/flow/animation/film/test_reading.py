"""Reading: the exemplar's own pixels, within its range, and what of it may be read."""

import torch
from torch import Tensor

from flow.animation.film.reading import Reading
from flow.warps.warp import pixel_coordinates
from kwatra import Exemplar


def picture() -> Tensor:
    return torch.rand(2, 20, 30, generator=torch.Generator().manual_seed(3))


def test_whole_pixels_are_the_exemplars_bit_for_bit() -> None:
    read = Reading(Exemplar.of(picture()), "lanczos")
    place = pixel_coordinates((8, 9)) + torch.tensor([5.0, 7.0]).view(2, 1, 1)
    assert torch.equal(read(place), picture()[:, 7:15, 5:14])
    assert torch.equal(read(place[:, 3, 4:6]), picture()[:, 10, 9:11])


def test_what_is_read_stays_in_range_and_out_of_holes() -> None:
    hole = torch.ones(20, 30, dtype=torch.bool)
    hole[6:12, 9:15] = False
    exemplar = Exemplar.of(torch.where(hole, picture(), 9.0), masks=[hole])
    colors = Reading(exemplar, "lanczos")(pixel_coordinates((20, 30)) + 0.5)
    known = picture()[:, hole]
    assert bool((colors.amax((1, 2)) <= known.amax(1)).all())
    assert bool((colors.amin((1, 2)) >= known.amin(1)).all())


def test_a_place_is_usable_when_all_pixels_around_it_belong_to_one_image() -> None:
    hole = torch.ones(20, 30, dtype=torch.bool)
    hole[10, 10] = False
    usable = Reading(Exemplar.of(picture(), masks=[hole]), "bicubic").usable
    for x, y, right in (
        (0.0, 0.0, True),
        (29.0, 19.0, True),
        (29.01, 5.0, False),
        (-0.01, 5.0, False),
        (5.0, 19.5, False),
        (10.0, 10.0, False),
        (9.5, 9.5, False),
        (9.0, 9.5, True),
        (11.0, 10.0, True),
    ):
        assert bool(usable(torch.tensor([x, y]).view(2, 1, 1))) == right, (x, y)


def test_texture_is_lost_from_two_px_beyond_what_is_usable() -> None:
    hole = torch.ones(20, 30, dtype=torch.bool)
    hole[6:14, 9:19] = False
    lost = Reading(Exemplar.of(picture(), masks=[hole]), "bicubic").lost
    places = {(0.0, 0.0): False, (-2.0, 5.0): False, (-2.1, 5.0): True, (31.0, 21.0): False, (31.1, 5.0): True,
              (5.0, -9.0): True, (10.0, 10.0): False, (11.0, 10.0): True, (13.5, 9.5): True}  # fmt: skip
    x, y = torch.tensor(list(places)).T
    assert lost(torch.stack([x, y])[:, None]).tolist() == [list(places.values())]


def test_a_sources_pixel_is_the_nearest_there_is() -> None:
    hole = torch.ones(20, 30, dtype=torch.bool)
    hole[6:14, 9:19] = False
    pixels = Reading(Exemplar.of(picture(), masks=[hole]), "bicubic").pixels
    source = torch.tensor([[[3.4, -2.0, 31.0, 10.0]], [[5.6, 4.0, 25.0, 9.0]]])
    assert pixels(source).tolist() == [[[6, 4, 19, 9]], [[3, 0, 29, 8]]]


def test_a_picture_is_what_is_read_but_for_its_seams() -> None:
    read = Reading(Exemplar.of(picture()), "bicubic")
    whole = torch.ones(8, 9, dtype=torch.bool)
    source = pixel_coordinates((8, 9)) + 4.25
    assert torch.equal(read.picture(source, whole), read(source))
    source[0, :, 5:] += 8
    soft = read.picture(source, whole)
    assert torch.equal(soft[:, :, :4], read(source)[:, :, :4])
    assert not torch.equal(soft[:, :, 4:6], read(source)[:, :, 4:6])
