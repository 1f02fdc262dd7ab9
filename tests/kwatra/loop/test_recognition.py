import pytest
import torch
from made import MADE

from kwatra import Exemplar, HardPixels, SoftPixels, begin, optimize
from kwatra.base import generator_of
from kwatra.loop.recognition import recognized

SIZE = 96


def texture():
    return MADE["stones"](SIZE, 16, 0).image


def kept(*parts, size=160, channels=3):
    """Hard pixels of an image of 0 on which parts (image (C, H, W), corner) are pasted."""
    target, where = torch.zeros(channels, size, size), torch.zeros(1, size, size, dtype=torch.bool)
    for image, (down, right) in parts:
        box = (slice(down, down + image.shape[1]), slice(right, right + image.shape[2]))
        target[:, *box], where[:, *box] = image, True
    return HardPixels(target, where)


def red(height, width):
    return torch.tensor([1.0, 0.0, 0.0]).view(3, 1, 1).expand(3, height, width)


def test_copies_tell_where_they_are_from():
    image = texture()
    term = kept((image[:, 20:60, 30:80], (100, 7)), (image[:, :17, :9], (3, 90)))
    (seen,) = recognized((term,), Exemplar.of(image))
    assert torch.equal(seen.where, term.where)
    inside = term.where[0]
    assert bool((seen.source[:, ~inside] == -1).all())
    torch.testing.assert_close(image[:, *seen.source[:, inside]], term.target[:, inside])
    assert seen.source[:, 100, 7].tolist() == [20, 30]
    assert seen.source[:, 3, 90].tolist() == [0, 0]


def test_copies_are_found_in_every_image_around_holes_and_though_they_are_noisy():
    images = [texture(), MADE["coins"](SIZE, 16, 0).image]
    masks = [None, torch.ones(SIZE, SIZE, dtype=torch.bool)]
    masks[1][:30, :30] = False
    exemplar = Exemplar.of(images, masks=masks)
    noise = 0.15 * float(images[1].std()) * torch.randn(3, 30, 30, generator=generator_of(0))
    (seen,) = recognized(
        (
            kept(
                (images[1][:, 50:80, 40:70] + noise, (0, 0)),
            ),
        ),
        exemplar,
    )
    number, down, right = exemplar.origin[:, *seen.source[:, 0, 0]].tolist()
    assert (number, down, right) == (1, 50, 40)


def test_what_is_hidden_in_the_exemplar_is_no_copy():
    image, mask = texture(), torch.ones(SIZE, SIZE, dtype=torch.bool)
    mask[40:50, 40:50] = False
    term = kept((image[:, 30:70, 30:70], (10, 10)))
    assert recognized((term,), Exemplar.of(image))[0].source is not None
    assert recognized((term,), Exemplar.of(image, masks=[mask]))[0].source is None


def test_what_is_foreign_is_left_out_of_what_blocks_see():
    exemplar = Exemplar.of(texture())
    assert recognized((kept((red(40, 60), (20, 20))),), exemplar) == ()


@pytest.mark.parametrize("width", [2, 5])
def test_strokes_narrower_than_a_window_are_foreign_too(width):
    strokes = [(red(30, width), (20, 20 + 4 * width * number)) for number in range(4)]
    assert recognized((kept(*strokes),), Exemplar.of(texture())) == ()


def test_parts_are_told_apart():
    image, other = texture(), MADE["stones"](SIZE, 16, 5).image
    term = kept((image[:, 10:50, 10:50], (0, 0)), (red(30, 30), (60, 60)), (other[:, :40, :40], (110, 110)))
    (seen,) = recognized((term,), Exemplar.of(image))
    assert seen.source[:, 0, 0].tolist() == [10, 10]
    assert not bool(seen.where[:, 60:90, 60:90].any())  # foreign
    assert bool(seen.where[:, 110:150, 110:150].all())  # of the like, from nowhere
    assert bool((seen.source[:, 110:150, 110:150] == -1).all())


def test_a_term_is_all_copied_only_if_each_of_its_parts_is_a_copy():
    exemplar = Exemplar.of(checker(64))
    copy = kept((checker(64)[:, 5:35, 2:40], (20, 20)))
    other = kept((checker(64)[:, :30, :38].roll(3, 2), (90, 90)))  # torn
    both = HardPixels(copy.target + other.target, copy.where | other.where)
    (seen,) = recognized((both,), exemplar)
    assert not seen.all_copied
    (seen,) = recognized((copy,), exemplar)
    assert seen.all_copied
    assert not copy.all_copied


def test_other_terms_and_what_tells_its_source_are_as_they_were():
    image = texture()
    term = kept((image[:, 10:50, 10:50], (0, 0)))
    told = HardPixels(term.target, term.where, source=torch.where(term.where, 5, -1).expand(2, -1, -1))
    soft = SoftPixels(term.target, term.where.float())
    one_channel = HardPixels(term.target, torch.tensor([True, False, False]).view(3, 1, 1).expand_as(term.target))
    nothing = HardPixels(term.target, torch.zeros_like(term.where))
    terms = told, soft, one_channel, nothing
    seen = recognized(terms, Exemplar.of(image))
    assert all(after is before for after, before in zip(seen, terms, strict=True))


def test_of_an_exemplar_smaller_than_a_window_nothing_is_recognized():
    image = texture()[:, :6, :40]
    term = kept((image, (0, 0)))
    assert recognized((term,), Exemplar.of(image))[0] is term


def checker(size, cell=8):
    line = torch.arange(size) // cell % 2
    return (line[:, None] ^ line[None]).float().expand(3, -1, -1)


def test_a_periodic_picture_goes_on_behind_what_is_foreign_and_in_step_with_a_copy():
    exemplar, whole = Exemplar.of(checker(64)), checker(160)
    logo = kept((red(50, 70), (40, 33)))
    made = optimize(exemplar, (160, 160), terms=logo, seed=1)
    inside = logo.where[0]
    assert torch.equal(made.image[:, inside], logo.target[:, inside])
    first = next(
        (down, right)
        for down in range(16)
        for right in range(16)
        if torch.equal(made.image[:, ~inside], whole.roll((down, right), (1, 2))[:, ~inside])
    )
    assert first is not None
    made = optimize(exemplar, (160, 160), terms=kept((checker(64)[:, 5:45, 2:50], (61, 50))), seed=1)
    torch.testing.assert_close(made.image, whole.roll((61 - 5, 50 - 2), (1, 2)))


def test_stones_go_on_behind_what_is_foreign():
    image = texture()
    plain = begin(Exemplar.of(image), (160, 160), seed=2)
    behind = begin(Exemplar.of(image), (160, 160), terms=kept((red(60, 60), (50, 50))), seed=2)
    assert torch.equal(plain.where, behind.where)
