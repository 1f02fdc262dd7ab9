import pytest
import torch

from kwatra import InputError, Quadratic, Scaled, SoftPixels, Sum, Term
from kwatra.terms.algebra import charge_of, parts_of, place_charge_of
from kwatra.terms.controls import wish_of


def soft(weight=1.0, value=0.5, name="soft pixels"):
    return SoftPixels(torch.full((1, 8, 8), value), torch.full((1, 8, 8), weight), name)


class Plain:
    name = "plain"

    def at(self, factor, shape):
        return self

    def energy(self, x):
        return float((x**2).mean())

    def quadratic(self, x):
        return Quadratic(torch.ones_like(x), torch.zeros_like(x))


def test_terms_add_and_scale():
    a, b = soft(), Plain()
    total = 2.0 * a + b
    assert isinstance(total, Sum)
    assert [t.name for t in parts_of(total)] == ["soft pixels", "plain"]
    x = torch.zeros(1, 8, 8)
    scaled = parts_of(3.0 * total)
    assert scaled[0].energy(x) == pytest.approx(6 * a.energy(x))
    assert torch.equal(scaled[0].quadratic(x).diagonal, 6 * a.quadratic(x).diagonal)


def test_scaling_an_operator_scales_its_product():
    inner = Quadratic(torch.ones(1, 2, 2), torch.zeros(1, 2, 2), lambda v: 5 * v)

    class Operator(Plain):
        def quadratic(self, x):
            return inner

    x = torch.ones(1, 2, 2)
    assert torch.equal(Scaled(2.0, Operator()).quadratic(x).times(x), 10 * x)


def test_soft_pixels_value_is_equation_23_per_pixel():
    term = soft(weight=2.0, value=0.25)
    assert term.energy(torch.zeros(1, 8, 8)) == pytest.approx(2 * 0.25**2)


def test_coarse_soft_pixels_keep_wanted_values_whole():
    target, weight = torch.zeros(1, 8, 8), torch.zeros(1, 8, 8)
    target[:, 3, 3], weight[:, 3, 3] = 0.8, 1.0
    target[:, 0, 0] = torch.nan  # weight zero: its value must not matter
    coarse = SoftPixels(target, weight).at((4, 4), (2, 2))
    assert float(coarse.target[0, 0, 0]) == pytest.approx(0.8)
    assert float(coarse.weight[0, 0, 0]) == pytest.approx(1 / 16)
    assert float(coarse.weight[0, 1, 1]) == 0.0


def test_the_wish_of_diagonal_terms_is_their_weighted_mean():
    x = torch.full((1, 8, 8), 0.3)
    wish = wish_of([soft(1.0, 0.0).quadratic(x), soft(3.0, 1.0).quadratic(x)], x)
    assert torch.allclose(wish.weight, torch.full_like(x, 4.0))
    assert torch.allclose(wish.value, torch.full_like(x, 0.75))


def test_the_wish_of_an_operator_has_its_gradient_at_x():
    generator = torch.Generator().manual_seed(0)
    root = torch.rand(16, 16, generator=generator)
    matrix = root @ root.T
    c, x = torch.rand(1, 4, 4, generator=generator), torch.rand(1, 4, 4, generator=generator)
    q = Quadratic(matrix.diagonal().view(1, 4, 4), c, lambda v: (matrix @ v.flatten()).view(1, 4, 4))
    wish = wish_of([q], x)
    assert torch.allclose(wish.weight * (x - wish.value), q.times(x - c), atol=1e-5)


def test_what_is_not_a_term_is_named():
    class Half:
        name = "half"

        def energy(self, x):
            return 0.0

    with pytest.raises(InputError, match="has no at, quadratic"):
        parts_of([Half()])
    with pytest.raises(InputError, match="finite and >= 0"):
        Scaled(-1.0, soft())
    with pytest.raises(InputError, match="same size"):
        SoftPixels(torch.zeros(1, 4, 4), torch.zeros(1, 4, 5))
    with pytest.raises(InputError, match="negative, NaN or infinite"):
        SoftPixels(torch.zeros(1, 4, 4), torch.full((1, 4, 4), -1.0))


class Charging(Term):
    name = "charging"

    def __init__(self, answer):
        self.answer = answer

    def at(self, factor, shape):
        return self

    def quadratic(self, x):
        return Quadratic(torch.zeros_like(x), x)

    def charge(self, x, step):
        return lambda corners, windows: self.answer(windows)

    def place_charge(self, exemplar, shape, width):
        return lambda corners, there: self.answer(there)


def test_a_charge_is_one_number_for_each_candidate():
    corners, windows, there = torch.zeros(3, 2), torch.ones(3, 8, 8, 1), torch.ones(3, 5, 2)
    term = 2.0 * Charging(lambda of: of.flatten(1).sum(1))
    assert charge_of(term, None, None)(corners, windows).tolist() == [128.0] * 3
    assert place_charge_of(2.0 * Charging(lambda of: of.sum(-1)), None, (), ())(corners, there).shape == (3, 5)
    for answer, wrong in [
        (lambda of: of.mean(-2), r"a tensor \(3, .*\)"),
        (lambda of: 1.0, "a float"),
        (lambda of: of.flatten(2).mean(2) * torch.nan, r"NaN|a tensor \(3, 8\)"),
    ]:
        with pytest.raises(InputError, match=rf"'charging' charges ({wrong}) for candidates .* a tensor \(3,\) of"):
            charge_of(2.0 * Charging(answer), None, None)(corners, windows)
        with pytest.raises(InputError, match=rf"'charging' charges ({wrong}) for candidates .* a tensor \(3, 5\) of"):
            place_charge_of(2.0 * Charging(answer), None, (), ())(corners, there)
