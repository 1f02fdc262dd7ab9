"""Statistics of textures: what a step does to an image, judged by plenoptic's own statistics where it can be."""

import numpy as np
import pytest
import torch
from scipy.ndimage import gaussian_filter
from torch import Tensor

from kwatra import InputError
from synth.metamorphosis.patches import statistics
from synth.metamorphosis.patches.statistics import Statistics, mixed, step


def stones(size: int, seed: int) -> Tensor:
    """A texture with edges, grain and two colors, (3, size, size)."""
    generator = np.random.default_rng(seed)
    rough = gaussian_filter(generator.standard_normal((2, size, size)), (0, 3, 3), mode="wrap")
    shape = torch.from_numpy(np.tanh(15 * rough)).float()
    grain = torch.from_numpy(generator.standard_normal((3, size, size))).float()
    colors = torch.tensor([[0.25, 0.2, 0.05], [0.0, 0.1, 0.15]])
    return (0.5 + torch.einsum("khw,kc->chw", shape, colors) + 0.03 * grain).clamp(0, 1)


def blurred(image: Tensor, sigma: float = 1.0) -> Tensor:
    return torch.from_numpy(gaussian_filter(image.numpy(), (0, sigma, sigma)))


def detail(image: Tensor) -> float:
    return float((image - blurred(image)).std())


def repeated(image: Tensor, target: Statistics, times: int, wrap: bool = False) -> Tensor:
    for _ in range(times):
        image = step(image, target, wrap)
    return image


def parts(image: Tensor) -> list[Tensor]:
    """What a step moves of the two finest octaves."""
    own = Statistics.of(image)
    return [own.finest, *(octave.bands for octave in own.octaves[:2]), own.octaves[0].magnitudes]


def far(one: Tensor, other: Tensor) -> float:
    return float((one - other).norm() / other.norm())


def apart(image: Tensor, exemplar: Tensor) -> float:
    """How far the statistics of Portilla and Simoncelli of two images are apart, as plenoptic measures them."""
    from plenoptic.models import PortillaSimoncelli

    one, other = (PortillaSimoncelli(i.shape[1:], 3)(i.mean(0)[None, None])[0, 0] for i in (image, exemplar))
    return float((one - other).norm() / other.norm())


@pytest.mark.parametrize("shape", [(3, 64, 64), (1, 16, 16), (2, 37, 51), (4, 130, 20)])
@pytest.mark.parametrize("wrap", [False, True])
def test_an_exemplar_stays_as_it_is(shape, wrap):
    image = torch.rand(shape, generator=torch.Generator().manual_seed(0))
    if shape[0] == 3:
        image = stones(64, 0)
    made = repeated(image, Statistics.of(image, wrap), 3, wrap)
    torch.testing.assert_close(made, image, atol=1e-4, rtol=0)


def test_blur_is_undone_and_the_picture_stays():
    truth = stones(128, 1)
    exemplar, soft = truth[:, :96, :80], blurred(truth)
    target = Statistics.of(exemplar)
    made = repeated(soft, target, 10)
    assert detail(soft) < 0.4 * detail(exemplar)
    assert detail(made) == pytest.approx(detail(exemplar), rel=0.1)
    assert float((made - truth).square().mean()) < float((soft - truth).square().mean())
    judged = [apart(image, truth) for image in (soft, made)]
    assert judged[1] < 0.7 * judged[0]
    assert float(made.min()) >= float(exemplar.min()) - 0.1
    assert float(made.max()) <= float(exemplar.max()) + 0.1


def test_every_step_leads_nearer():
    exemplar, image = stones(64, 0), blurred(stones(128, 1))
    target, distances = Statistics.of(exemplar), []
    for _ in range(6):
        distances.append([far(one, other) for one, other in zip(parts(image), parts(exemplar), strict=True)])
        image = step(image, target)
    finest, *bands = zip(*distances, strict=True)
    assert list(finest) == sorted(finest, reverse=True)  # what is hardly there at first grows by so much in every step
    assert finest[5] < 0.6
    for values in bands:
        assert values[1] < 0.5 * values[0]
        assert values[5] < 0.2 * values[0]


def test_many_steps_settle():
    exemplar, soft = stones(64, 0), blurred(stones(64, 1))
    made = repeated(soft, Statistics.of(exemplar), 30)
    after = step(made, Statistics.of(exemplar))
    assert float((after - made).abs().mean()) < 2e-3
    assert detail(made) == pytest.approx(detail(exemplar), rel=0.1)


def test_no_border_shows():
    """What steps change is no more at the border than inside."""
    soft = blurred(stones(96, 1))
    change = (repeated(soft, Statistics.of(stones(64, 0)), 10) - soft).square().mean(0)
    inside = float(change[8:-8, 8:-8].mean())
    for edge in (change[0], change[-1], change[:, 0], change[:, -1]):
        assert float(edge.mean()) < 2.5 * inside


def test_colors_go_together_as_in_the_exemplar():
    """Grain that is gray in the exemplar and of any color in the image becomes gray."""
    gray = torch.randn(1, 64, 64, generator=torch.Generator().manual_seed(0)).expand(3, -1, -1)
    colored = torch.randn(3, 64, 64, generator=torch.Generator().manual_seed(1))
    exemplar, image = 0.5 + 0.1 * gray, 0.5 + 0.1 * colored
    made = repeated(image, Statistics.of(exemplar), 10)
    assert float(torch.corrcoef(image.flatten(1))[0, 1:].max()) < 0.1
    assert float(torch.corrcoef(made.flatten(1))[0, 1:].min()) > 0.97


def test_magnitudes_go_together_as_in_the_exemplar():
    """Grain in places only: where the coarse is strong the fine is; bands' variances alone know nothing of that."""
    where = stones(64, 0)[:1] > 0.5
    grain = torch.randn(1, 64, 64, generator=torch.Generator().manual_seed(0))
    coarse = blurred(grain, 1.5) * 5
    exemplar = 0.5 + 0.05 * where * (grain + coarse)
    other = torch.randn(1, 64, 64, generator=torch.Generator().manual_seed(1))
    image = 0.5 + 0.05 * (where * blurred(other, 1.5) * 5 + 0.6 * other)
    made = repeated(image, Statistics.of(exemplar), 10)

    def correlations(picture: Tensor) -> Tensor:
        magnitudes = Statistics.of(picture).octaves[0].magnitudes
        deviations = magnitudes.diagonal().sqrt()
        return magnitudes / deviations[:, None] / deviations

    wanted = correlations(exemplar)
    before, after = (float((correlations(i) - wanted).square().mean().sqrt()) for i in (image, made))
    assert before > 0.2
    assert after < 0.03  # 0.12 by bands and values alone


def test_statistics_are_mixed_linearly():
    parts = [Statistics.of(stones(size, 0)) for size in (64, 48, 32)]
    half = mixed(parts[:2], (0.25, 0.75))
    assert len(half.octaves) == 2
    torch.testing.assert_close(half.values.center, torch.lerp(*(p.values.center for p in parts[:2]), 0.75))
    torch.testing.assert_close(half.finest, torch.lerp(*(p.finest for p in parts[:2]), 0.75))
    torch.testing.assert_close(
        half.octaves[0].magnitudes, torch.lerp(*(p.octaves[0].magnitudes for p in parts[:2]), 0.75)
    )
    one = mixed(parts, (0, 0, 1))
    image = blurred(stones(40, 3))
    torch.testing.assert_close(step(image, one), step(image, parts[2]))
    assert len(mixed(parts, (0.2, 0.3, 0.5)).octaves) == 2


def test_what_does_not_count_says_nothing_of_a_texture():
    """The left half is to have an exemplar's detail, whatever the right half is."""
    exemplar, soft = stones(64, 0), blurred(stones(128, 1))
    share = (torch.arange(128) < 64).float().expand(128, 128)
    image = torch.where(share > 0, soft, soft.mean())
    share = share * (torch.arange(128) < 48)  # not the edge between them
    made, blind = (repeated_in(image, Statistics.of(exemplar), share, seen) for seen in (True, False))
    inner = (slice(None), slice(None), slice(0, 48))
    assert detail(made[inner]) == pytest.approx(detail(exemplar), rel=0.15)
    assert detail(blind[inner]) > 1.2 * detail(exemplar)
    whole = step(soft, Statistics.of(exemplar), share=torch.full((128, 128), 0.3))
    torch.testing.assert_close(whole, step(soft, Statistics.of(exemplar)), atol=1e-4, rtol=0)


def repeated_in(image: Tensor, target: Statistics, share: Tensor, seen: bool) -> Tensor:
    made = image
    for _ in range(10):
        made = torch.where(share > 0, step(made, target, share=share if seen else None), image)
    return made


def test_an_image_may_be_smaller_or_larger_than_its_exemplar():
    target = Statistics.of(stones(128, 0))
    assert len(target.octaves) == 4
    for shape in ((3, 16, 16), (3, 33, 200)):
        assert step(torch.rand(shape, generator=torch.Generator().manual_seed(0)), target).shape == shape


def test_a_plain_image_is_no_texture_but_no_error():
    plain = torch.full((3, 32, 32), 0.4)
    torch.testing.assert_close(step(plain, Statistics.of(plain)), plain)
    made = step(plain, Statistics.of(stones(64, 0)))
    assert bool(made.isfinite().all())
    assert bool(step(stones(64, 0), Statistics.of(plain)).isfinite().all())


def test_threads_do_not_change_bits():
    target, image = Statistics.of(stones(64, 0)), blurred(stones(128, 1))
    made = []
    for count in (1, 2, 3):
        torch.set_num_threads(count)
        made.append((step(image, target), Statistics.of(image).octaves[0].magnitudes))
    for other in made[1:]:
        assert all(torch.equal(*pair) for pair in zip(made[0], other, strict=True))


def test_bad_input_is_refused():
    good = Statistics.of(stones(32, 0))
    with pytest.raises(InputError, match=r"shape \(3, 15, 40\).* at least 16x16"):
        Statistics.of(torch.rand(3, 15, 40))
    with pytest.raises(InputError, match="1 channels and the statistics 3"):
        step(torch.rand(1, 32, 32), good)
    with pytest.raises(InputError, match=r"weights \(0.5, 0.4\); give one for each, of sum 1"):
        mixed([good, good], (0.5, 0.4))
    with pytest.raises(InputError, match="images of 3, 1 channels"):
        mixed([good, Statistics.of(torch.rand(1, 32, 32))], (0.5, 0.5))


def test_three_channels_are_turned_to_the_axes_of_ohta():
    turned = statistics._turned(torch.eye(3)[..., None])[..., 0]
    ohta = torch.tensor([[1.0, 1, 1], [1, 0, -1], [0.5, -1, 0.5]])
    torch.testing.assert_close(turned, ohta / ohta.norm(dim=1, keepdim=True))
