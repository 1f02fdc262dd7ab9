"""Morph targets as terms: colors and bands on their way, sureness, films made texture again."""

import itertools

import pytest
import torch
from pictures import cloud, disc, spots

import flow
import synth
from flow.animation import flow_term
from kwatra import Exemplar, InputError, Level, Settings, optimize
from synth.metamorphosis.bands import Bands
from synth.metamorphosis.method import Film, Pair
from synth.metamorphosis.recolor import Colors, barycenter, recolored
from synth.metamorphosis.retexture import Retexture, Sources, morph_target, sureness


def silent(what: str, part: float) -> None:
    """Tell nobody."""


def sharpness(image: torch.Tensor) -> float:
    return float((image[:, :, 1:] - image[:, :, :-1]).square().mean().sqrt())


def test_colors_arrive_where_they_were_sent():
    a, b = spots(40, 0, 0.8), 0.3 + 0.5 * spots(40, 1, 0.2)
    own, other = Colors.of(a), Colors.of(b)
    made = Colors.of(recolored(a, own, other))
    torch.testing.assert_close(made.center, other.center, atol=1e-5, rtol=0)
    torch.testing.assert_close(made.covariance, other.covariance, atol=5e-5, rtol=0)
    half, between = Colors.of(recolored(a, own, other, 0.5)), barycenter((own, other), (0.5, 0.5))
    torch.testing.assert_close(half.center, between.center, atol=1e-5, rtol=0)
    torch.testing.assert_close(half.covariance, between.covariance, atol=5e-5, rtol=0)
    assert torch.equal(recolored(a, own, other, 0), a)


def test_the_transport_is_the_shortest():
    """Any other linear map that leads to the same Gaussian, such as one with a turn, moves colors farther."""
    a, b = spots(40, 0, 0.8), 0.3 + 0.5 * spots(40, 1, 0.2)
    own, other = Colors.of(a), Colors.of(b)
    least = float((recolored(a, own, other) - a).square().mean())
    root_a, root_b = (torch.linalg.cholesky(colors.covariance) for colors in (own, other))
    turned = root_b @ torch.linalg.inv(root_a)
    moved = other.center + turned @ (a.flatten(1).double() - own.center)
    assert float((moved.view_as(a) - a).square().mean()) > least


def test_bands_give_back_what_a_blur_took():
    image = spots(48, 0, 0.8)
    soft = torch.nn.functional.avg_pool2d(image[None], 3, 1, 1, count_include_pad=False)[0]
    restored = Bands.of(image).given_to(soft)
    assert sharpness(soft) < 0.8 * sharpness(image)
    assert sharpness(restored) == pytest.approx(sharpness(image), rel=0.1)
    torch.testing.assert_close(Bands.of(image).given_to(image), image, atol=1e-3, rtol=0)


def test_the_morph_is_sure_where_nothing_changes_and_unsure_where_a_disc_appears():
    a, b = cloud(48, 0, 0), cloud(48, 0, 0)
    b[:, 18:30, 18:30] = 1 - b[:, 18:30, 18:30]
    film = synth.morph(a, b, 3, method="control", preset="fast").film
    pair = Pair(a, b)
    sure = sureness(film, pair, 0.5)
    assert float(sure.min()) > 0
    assert float(sure.max()) <= 1
    assert float(sure[20:28, 20:28].mean()) < 0.5 * float(sure[:10].mean())
    for end in (0.0, 1.0):
        assert torch.equal(sureness(film, pair, end), torch.ones(48, 48))
    assert torch.equal(sureness(Film(film.frames, film.times), pair, 0.5), torch.ones(48, 48))
    term = morph_target(film, pair, 1, weight=2.0)
    assert torch.equal(term.target, film.frames[1])
    assert torch.equal(term.weight, 2 * sure[None])
    with pytest.raises(InputError, match="the film has frames 0 to 2"):
        morph_target(film, pair, 3)


def test_retextured_frames_are_sharp_and_the_ends_stay():
    a, b = spots(56, 0, 0.8), spots(56, 1, 0.3)
    plain = synth.morph(a, b, 5, method="blend")
    made = synth.morph(a, b, 5, method="blend", retexture=True, preset="fast")
    torch.testing.assert_close(made.frames[0], a, atol=1e-6, rtol=0)
    torch.testing.assert_close(made.frames[-1], b, atol=1e-6, rtol=0)
    ends = (sharpness(a) + sharpness(b)) / 2
    assert sharpness(plain.frames[2]) < 0.85 * ends
    assert 0.85 * ends < sharpness(made.frames[2]) < 1.15 * ends
    assert float((made.frames[2] - plain.frames[2]).abs().mean()) < 0.1


def test_a_film_does_not_boil():
    """Frames made from the one before, carried along, change less than frames that each begin anew."""
    a, b = spots(56, 0, 0.8), spots(56, 1, 0.3)
    times = [0.4, 0.45, 0.5]
    film = synth.morph(a, b, times, method="control", preset="fast").film
    retexture = Retexture(weight=0.05, levels=(Level(1, 8, 2),))
    joined = retexture(Pair(a, b), film, 0, silent).frames
    apart = [
        retexture(Pair(a, b), Film((frame,), (time,), film.velocity), 0, silent).frames[0]
        for frame, time in zip(film.frames, times, strict=True)
    ]

    def change(frames):
        return sum(float((y - x).square().mean()) for x, y in itertools.pairwise(frames))

    assert torch.equal(joined[0], apart[0])
    assert change(joined) < change(apart)


def test_both_textures_are_drawn_on_and_b_more_the_later():
    a, b = spots(56, 0, 0.8), 1 - spots(56, 1, 0.3)
    film = synth.morph(a, b, [0.2, 0.8], method="control", preset="fast").film
    pair, shares = Pair(a, b), []
    for number, time in enumerate(film.times):
        exemplar = Sources.of(pair).at(time)
        settings = Settings(levels=(Level(1, 8, 2),))
        term = morph_target(film, pair, number)
        result = optimize(exemplar, (56, 56), settings=settings, terms=term, start=film.frames[number])
        shares.append(float((result.source[0] == 1).float().mean()))
    assert shares[0] < 0.4 < 0.6 < shares[1]


def test_a_texture_flows_while_it_turns_into_another():
    """Two terms: the frame before, carried along the flow, and the morph's frame, carried as far."""
    a, b = spots(48, 0, 0.8), spots(48, 1, 0.3)
    pair = Pair(a, b, tile=True)
    film = synth.morph(a, b, 5, method="control", tile=True, preset="fast").film
    look = flow.lookup(torch.tensor([3.0, 0.0]).view(2, 1, 1).expand(2, 48, 48).contiguous(), wrap=True)
    settings = Settings(levels=(Level(1, 8, 2),), wrap=True)
    place = flow.warps.pixel_coordinates((48, 48))
    frame, seen = a, []
    for number in range(1, 4):
        place = place - (flow.warps.pixel_coordinates((48, 48)) - look.coordinates)
        target = morph_target(film, pair, number)
        moved = type(target)(
            flow.warp(target.target, place, wrap=True), flow.warp(target.weight, place, "bilinear", True)
        )
        carried = flow.warp(frame, look.coordinates, wrap=True)
        terms = flow_term(frame, look, 1.0) + moved
        exemplar: Exemplar = Sources.of(pair).at(film.times[number])
        after = optimize(exemplar, (48, 48), settings=settings, terms=terms, start=carried).image
        seen.append(float((after - carried).square().mean()) / float((after - frame).square().mean()))
        frame = after
    assert max(seen) < 0.5
    back = flow.warp(frame, flow.warps.pixel_coordinates((48, 48)) + torch.tensor([9.0, 0.0]).view(2, 1, 1), wrap=True)
    assert float((back - film.frames[3]).abs().mean()) < 0.5 * float((frame - film.frames[3]).abs().mean())


def test_a_mask_keeps_a_morph_target_within_it():
    a, b = spots(40, 0, 0.8), spots(40, 1, 0.3)
    film = synth.morph(a, b, 3, method="blend").film
    mask = disc(40, 20, 20, 14)[0] > 0.4
    term = morph_target(film, Pair(a, b), 1)
    settings = Settings(levels=(Level(1, 8, 2),))
    result = optimize(Sources.of(Pair(a, b)).at(0.5), (40, 40), settings=settings, terms=term, mask=mask)
    assert not result.image[:, ~mask].any()
    assert float((result.image - film.frames[1])[:, mask].abs().mean()) < 0.12
