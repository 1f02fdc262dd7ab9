from itertools import pairwise

import faiss
import pytest
import torch

from kwatra import (
    Exemplar,
    Feature,
    InputError,
    Level,
    Quadratic,
    Settings,
    SoftPixels,
    gradient,
    optimize,
)

SMALL = (Level(2, 8, 3), Level(1, 8, 3))


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def texture(size=48, channels=1, seed=0):
    noise = torch.rand(1, channels, size + 4, size + 4, generator=generator(seed))
    smooth = torch.nn.functional.avg_pool2d(noise, 5, 1)[0]
    return (smooth - smooth.amin()) / (smooth.amax() - smooth.amin())


def checkerboard(size, square):
    y, x = torch.meshgrid(torch.arange(size), torch.arange(size), indexing="ij")
    return ((y // square + x // square) % 2).float()[None]


@pytest.mark.parametrize("features", [(), (Feature(gradient, 1.0),)])
@pytest.mark.parametrize("r", [2.0, 0.8])
def test_em_never_raises_the_energy_on_a_level(r, features):
    # the metric is exact (full search, falloff alike in search and blend), so both steps can only lower it
    settings = Settings(levels=(Level(1, 8, 8, route="exact"),), r=r, features=features)
    rows = optimize(Exemplar.of(texture()), (40, 44), settings=settings, start="windows").energies
    energies = [row["texture"] for row in rows]
    assert len(energies) == 8
    assert energies[-1] < 0.97 * energies[0]
    assert all(b <= a * 1.001 for a, b in pairwise(energies))


def test_a_piece_of_the_exemplar_as_the_start_stays_put():
    z = texture(64, 3)
    result = optimize(Exemplar.of(z), (40, 40), settings=Settings(levels=SMALL), start=z[:, 8:48, 12:52])
    assert torch.allclose(result.image, z[:, 8:48, 12:52], atol=1e-5)
    rows, columns = torch.meshgrid(torch.arange(40), torch.arange(40), indexing="ij")
    assert torch.equal(result.source[1:], torch.stack([rows + 8, columns + 12]))
    assert "settled" in result.stopped


@pytest.mark.parametrize("levels", [None, (Level(1, 8, 3),)])
def test_a_constant_exemplar_gives_a_constant_output(levels):
    result = optimize(Exemplar.of(torch.full((3, 32, 32), 0.25)), (50, 37), settings=Settings(levels=levels))
    assert result.image.shape == (3, 50, 37)
    assert torch.allclose(result.image, torch.tensor(0.25), atol=1e-6)


@pytest.mark.parametrize("shape", [(64, 64), (37, 91), (9, 70)])
@pytest.mark.parametrize("wrap", [False, True])
def test_any_shape_is_filled_with_the_exemplars_colors(shape, wrap):
    z = texture(48, 2)
    result = optimize(Exemplar.of(z), shape, settings=Settings(wrap=wrap))
    assert result.image.shape == (2, *shape)
    assert bool(((result.image > -1e-4) & (result.image < 1 + 1e-4)).all())
    seen = z[:, result.source[1], result.source[2]]
    # most pixels are nearly verbatim where the map says they come from
    assert float((result.image - seen).abs().median()) < 0.03


def test_same_seed_same_bits_for_any_number_of_threads():
    z = texture(64, 3)
    images = []
    for threads in (1, 2):
        torch.set_num_threads(threads)
        faiss.omp_set_num_threads(threads)
        levels = (Level(4, 8), Level(1, 8, 2, route="exact"), Level(1, 8, 2, route="approximate"))
        images.append(
            [optimize(Exemplar.of(z), (150, 140), settings=s).image for s in (Settings(), Settings(levels=levels))]
        )
    for one, two in zip(*images, strict=True):
        assert torch.equal(one, two)


def test_another_seed_gives_another_image_and_global_randomness_is_left_alone():
    exemplar = Exemplar.of(texture())
    state = torch.random.get_rng_state()
    a, b = (optimize(exemplar, (40, 40), settings=Settings(levels=SMALL), seed=s).image for s in (0, 1))
    assert not torch.equal(a, b)
    assert torch.equal(torch.random.get_rng_state(), state)


def test_a_wrapped_output_repeats_the_lattice_without_a_break():
    result = optimize(Exemplar.of(checkerboard(48, 6)), (72, 60), settings=Settings(wrap=True))
    black = result.image > 0.5
    assert torch.equal(black, black.roll((12, 0), (1, 2)))
    assert torch.equal(black, black.roll((6, 6), (1, 2)))


def test_stages_and_energies_tell_what_was_done():
    calls = []
    result = optimize(Exemplar.of(texture()), (40, 40), settings=Settings(levels=SMALL), callback=calls.append)
    assert [(s.level, s.factor, s.width, tuple(s.image.shape)) for s in result.stages] == [
        (0, 2, 8, (1, 20, 20)),
        (1, 1, 8, (1, 40, 40)),
    ]
    assert torch.equal(result.stages[-1].image, result.image)
    assert len(calls) == len(result.energies)
    assert all(row["total"] == row["texture"] and row["route"] == "exact" for row in result.energies)
    fractions = [c.fraction for c in calls]
    assert fractions == sorted(fractions)
    assert 0 < fractions[0] <= fractions[-1] == 1


def test_a_level_that_settles_early_is_done():
    calls, settings, noise = [], Settings(levels=(Level(1, 8, 20),)), texture()
    still = optimize(Exemplar.of(noise), (40, 40), settings=settings, start=noise[:, :40, :40], callback=calls.append)
    assert len(calls) < 20
    assert "settled" in still.stopped
    assert calls[-1].fraction == 1


def test_routes_can_be_forced():
    for route in ("exact", "approximate", "coherent"):
        settings = Settings(levels=(Level(2, 8, 1), Level(1, 8, 1, route=route)))
        rows = optimize(Exemplar.of(texture()), (40, 40), settings=settings).energies
        assert rows[-1]["route"] == route


def test_ending_below_full_resolution_shows_the_matches_at_full_resolution():
    z = texture()
    result = optimize(Exemplar.of(z), (40, 41), settings=Settings(levels=(Level(2, 8, 2),)))
    assert torch.equal(result.image, z[:, result.source[1], result.source[2]])


@pytest.mark.parametrize("start", ["blocks", "windows"])
def test_other_starts_also_end_in_texture(start):
    z = texture()
    result = optimize(Exemplar.of(z), (48, 48), settings=Settings(levels=SMALL), start=start)
    assert result.energies[-1]["texture"] < result.energies[0]["texture"]
    assert result.image.std() > 0.6 * z.std()


class Gray:
    """A user's own term: a plain class. The left half should be white."""

    name = "white left"

    def __init__(self, shape, weight=4.0):
        self.weight = torch.zeros(1, *shape)
        self.weight[..., : shape[-1] // 2] = weight

    def at(self, factor, shape):
        return Gray(shape, float(self.weight.max()))

    def energy(self, x):
        return float((self.weight * (x - 1) ** 2).mean())

    def quadratic(self, x):
        return Quadratic(self.weight, torch.ones_like(x))


def test_a_plain_user_class_is_a_term_of_the_energy():
    z = texture(64)
    result = optimize(Exemplar.of(z), (40, 40), settings=Settings(levels=SMALL), terms=Gray((40, 40)))
    left, right = result.image[..., :20].mean(), result.image[..., 20:].mean()
    free = optimize(Exemplar.of(z), (40, 40), settings=Settings(levels=SMALL)).image
    assert left > free[..., :20].mean() + 0.1
    assert abs(float(right - free[..., 20:].mean())) < 0.15
    row = result.energies[-1]
    assert row["total"] == pytest.approx(row["texture"] + row["white left"])


def test_the_search_takes_the_terms_into_account():
    # Half white, half black exemplar; the output starts black and is wanted at 0.8 everywhere, weight 1. The blend
    # alone would stop at 0.4, still nearer to black windows than to white ones; equation 26 makes white ones cheaper.
    z = torch.cat([torch.zeros(1, 32, 16), torch.ones(1, 32, 16)], 2)
    want = SoftPixels(torch.full((1, 24, 24), 0.8), torch.ones(1, 24, 24))
    settings = Settings(levels=(Level(1, 8, 4, route="exact"),), wrap=True)

    def found(factor):
        terms = factor * want
        return optimize(Exemplar.of(z), (24, 24), settings=settings, terms=terms, start=torch.zeros(1, 24, 24))

    assert torch.allclose(found(0.2).image, torch.tensor(0.2 * 0.8 / 1.2), atol=1e-5)
    assert torch.allclose(found(1.0).image, torch.tensor((1 + 0.8) / 2), atol=1e-5)
    assert int(found(1.0).source[2].min()) >= 16


def test_an_operator_term_and_a_feature_work_together():
    class Smooth:
        """(x - 0)^T D^T D (x - 0) along rows."""

        name = "smooth"

        def at(self, factor, shape):
            return self

        def energy(self, x):
            return float(x.diff(dim=2).square().sum() / x.numel())

        def quadratic(self, x):
            def apply(v):
                out = torch.zeros_like(v)
                d = v.diff(dim=2)
                out[:, :, 1:] += d
                out[:, :, :-1] -= d
                return 10 * out

            diagonal = torch.full_like(x, 20.0)
            diagonal[:, :, 0] = diagonal[:, :, -1] = 10.0
            return Quadratic(diagonal, torch.zeros_like(x), apply)

    settings = Settings(levels=SMALL, features=(Feature(gradient, 0.5),))
    z = texture()
    rough = optimize(Exemplar.of(z), (32, 32), settings=settings).image
    smooth = optimize(Exemplar.of(z), (32, 32), settings=settings, terms=Smooth()).image
    assert Smooth().energy(smooth) < 0.5 * Smooth().energy(rough)


def test_videos_are_synthesized_by_the_same_loop():
    noise = torch.rand(1, 10, 36, 36, generator=generator())
    video = torch.nn.functional.avg_pool3d(noise, (3, 5, 5), 1)
    video = (video - video.amin()) / (video.amax() - video.amin())
    settings = Settings(levels=(Level(2, 8, 2), Level(1, 8, 2)))
    result = optimize(Exemplar.of(video), (10, 40, 36), settings=settings)
    assert result.image.shape == (1, 10, 40, 36)
    assert result.source.shape == (4, 10, 40, 36)
    seen = video[(slice(None), *result.source[1:])]
    assert float((result.image - seen).abs().median()) < 0.03
    assert result.image.std() > 0.7 * video.std()


def test_what_moves_in_a_video_moves_so_in_what_is_made_of_it():
    picture = texture(60)
    video = torch.stack([picture.roll(2 * t, 2)[:, :40, :40] for t in range(10)], 1)
    settings = Settings(levels=(Level(2, 8, 2), Level(1, 8, 2)))
    made = optimize(Exemplar.of(video), (12, 44, 40), settings=settings).image

    def error(step):
        """How far each frame is from the one before it, moved by so many pixels."""
        return float((made[:, 1:] - made[:, :-1].roll(step, 3))[..., 4:-4].abs().mean())

    assert error(2) < 0.03
    assert min(error(step) for step in (-2, -1, 0, 1, 3, 4)) > 4 * error(2)


def test_a_twirled_checkerboard_is_projected_back():
    from gallery_projection import ONE, THREE, checkerboard, repaired, twirled, wrong_pixels

    exemplar = checkerboard(96, 12)
    mild, strong = twirled(exemplar, 0.7), twirled(exemplar, 4.0)
    assert wrong_pixels(strong, exemplar) > 0.1
    assert wrong_pixels(repaired(mild, exemplar, ONE), exemplar) == 0
    one, three = (wrong_pixels(repaired(strong, exemplar, levels), exemplar) for levels in (ONE, THREE))
    assert three == 0 < one


def test_bad_requests_are_said_in_a_sentence():
    exemplar = Exemplar.of(texture())
    with pytest.raises(InputError, match=r"shape is \(40,\); give 2 whole numbers"):
        optimize(exemplar, (40,))
    with pytest.raises(InputError, match=r"shape is \(4, 40, 40\); give 2 whole numbers"):
        optimize(exemplar, (4, 40, 40))
    with pytest.raises(InputError, match=r"shape is \(40, 40.5\); give 2 whole numbers"):
        optimize(exemplar, (40, 40.5))
    with pytest.raises(InputError, match="the output is 1x1 pixels; at least 4x4 are needed"):
        optimize(exemplar, (1, 1))
    with pytest.raises(InputError, match="a level is 8 times coarser but the exemplar has only 48x7 pixels"):
        optimize(Exemplar.of(texture()[..., :7]), (40, 40), settings=Settings(levels=(Level(8, 4, 1), Level(1, 4, 1))))
    with pytest.raises(InputError, match="the start is 'noise'; give an image, or one of aligned, blocks"):
        optimize(exemplar, (40, 40), start="noise")
    with pytest.raises(InputError, match="the start image has shape"):
        optimize(exemplar, (40, 40), start=torch.zeros(1, 40, 41))
    with pytest.raises(InputError, match="start image holds NaN"):
        optimize(exemplar, (40, 40), start=torch.full((1, 40, 40), torch.nan))
    for settings, message in [
        ({"r": 0.0}, r"r is 0.0; the robust exponent"),
        ({"levels": ()}, "levels is empty"),
        ({"even": -1.0}, "even is -1.0; what even use"),
        ({"iterations": 0}, "iterations is 0 and seams 6; each is at least 1"),
        ({"block": 0.0}, r"block is 0.0; it is a share of the exemplar in \(0, 1\]"),
        ({"seams": 0}, "iterations is 4 and seams 0"),
    ]:
        with pytest.raises(InputError, match=message):
            Settings(**settings)
