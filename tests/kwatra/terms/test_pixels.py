import pytest
import torch

from kwatra import Exemplar, HardPixels, InputError, SoftPixels, optimize
from kwatra.terms import Controls


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def test_soft_pixels_weigh_channels_one_by_one():
    weight = torch.tensor([1.0, 0.0])[:, None, None].expand(2, 4, 4)
    term = SoftPixels(torch.zeros(2, 4, 4), weight)
    x = torch.full((2, 4, 4), 0.5)
    assert term.energy(x) == pytest.approx(0.25 / 2)
    assert torch.equal(term.at((2, 2), (2, 2)).weight, weight[:, :2, :2])


def test_soft_pixels_behind_a_mask_do_not_tint_coarse_blocks():
    mask = torch.ones(4, 4, dtype=torch.bool)
    mask[0, 0] = False
    target = torch.full((1, 4, 4), 0.25)
    target[0, 0, 0] = torch.nan
    coarse = SoftPixels(target, torch.ones(1, 4, 4)).within(mask).at((2, 2), (2, 2))
    assert torch.allclose(coarse.target, torch.tensor(0.25))
    assert coarse.weight.flatten().tolist() == [0.75, 1, 1, 1]


def test_whole_blocks_of_hard_pixels_are_hard_and_others_soft_by_their_share():
    target = torch.rand(2, 5, 4, generator=generator())
    where = torch.ones(1, 5, 4, dtype=torch.bool)
    where[0, 0, 0] = False
    held = torch.where(where, target, torch.nan)
    term = HardPixels(held, where, weight=2.0).at((2, 2), (3, 2))
    q = term.quadratic(torch.zeros(2, 3, 2))
    assert q.fixed.flatten().tolist() == [False, True, True, True, True, True]
    assert q.diagonal.flatten().tolist() == [1.5, 2, 2, 2, 2, 2]
    assert torch.allclose(q.target[:, 0, 0], (target[:, 0, 1] + target[:, 1, 0] + target[:, 1, 1]) / 3)
    assert torch.allclose(q.target[:, 1, 1], target[:, 2:4, 2:].mean((1, 2)))
    assert torch.allclose(q.target[:, 2, 1], target[:, 4, 2:].mean(1))  # the border cuts this block


def test_a_block_is_hard_when_all_its_unmasked_pixels_are():
    mask = torch.tensor([[True, True, True, True], [False, True, True, True]])
    where = torch.tensor([[[True, True, True, False], [True, True, True, True]]])
    term = HardPixels(torch.where(mask, 0.5, torch.nan)[None], where).within(mask).at((2, 2), (1, 2))
    q = term.quadratic(torch.zeros(1, 1, 2))
    assert q.fixed.flatten().tolist() == [True, False]
    assert torch.allclose(q.target, torch.tensor(0.5))


def test_hard_pixels_have_no_energy_where_they_are_kept():
    term = HardPixels(torch.full((1, 4, 4), 0.5), torch.ones(1, 4, 4, dtype=torch.bool))
    assert term.energy(torch.full((1, 4, 4), 0.5)) == 0
    assert term.energy(torch.zeros(1, 4, 4)) == pytest.approx(0.25)


def test_what_does_not_fit_is_said_in_a_sentence():
    target = torch.zeros(3, 4, 4)
    with pytest.raises(InputError, match=r"soft pixels have targets .* but weights .*give weights of the same size"):
        SoftPixels(target, torch.ones(2, 4, 4))
    with pytest.raises(InputError, match=r"hard pixels have targets .* but places"):
        HardPixels(target, torch.ones(1, 4, 5, dtype=torch.bool))
    with pytest.raises(InputError, match="the weight of hard pixels is -1"):
        HardPixels(target, torch.ones(1, 4, 4, dtype=torch.bool), weight=-1.0)
    for term in (SoftPixels(target, torch.ones(1, 4, 4)), HardPixels(target, torch.ones(1, 4, 4, dtype=torch.bool))):
        with pytest.raises(InputError, match=r"size \(4, 4\), but the output is \(4, 6\); crop or pad"):
            term.at((2, 2), (2, 3))


def test_hard_pixels_tell_where_they_are_copied_from_at_every_resolution():
    where = torch.ones(1, 4, 6, dtype=torch.bool)
    where[0, 0, 0] = False
    source = torch.stack(torch.meshgrid(torch.arange(8, 12), torch.arange(20, 26), indexing="ij"))
    term = HardPixels(torch.zeros(3, 4, 6), where, source=source)
    copied = term.copied()
    assert torch.equal(copied[:, where[0]], source[:, where[0]])
    assert copied[:, 0, 0].tolist() == [-1, -1]
    coarse = term.at((2, 2), (2, 3)).copied()
    assert coarse[0].tolist() == [[-1, 4, 4], [5, 5, 5]]
    assert coarse[1].tolist() == [[-1, 11, 12], [10, 11, 12]]
    assert HardPixels(torch.zeros(3, 4, 6), where).copied() is None
    assert term.all_copied
    assert not HardPixels(torch.zeros(3, 4, 6), where).all_copied
    assert not HardPixels(torch.zeros(3, 4, 6), where, source=torch.where(where, source, -1).roll(1, 2)).all_copied


@pytest.mark.parametrize("source", [torch.zeros(2, 4, 4), torch.zeros(3, 4, 4, dtype=torch.long)])
def test_a_source_that_is_none_is_refused(source):
    with pytest.raises(InputError, match=r"hard pixels have a source .*give whole numbers \(2, 4, 4\)"):
        HardPixels(torch.zeros(3, 4, 4), torch.ones(1, 4, 4, dtype=torch.bool), source=source)


def test_of_what_is_copied_from_the_exemplar_nothing_is_wished_and_the_first_term_tells_from_where():
    first, second = (torch.zeros(1, 4, 4, dtype=torch.bool) for _ in range(2))
    first[:, :2], second[:, 1:3] = True, True
    one, other = torch.full((2, 4, 4), 5), torch.full((2, 4, 4), 9)
    target = torch.full((1, 4, 4), 0.5)
    terms = (HardPixels(target, first, source=one), HardPixels(target, second, source=other))
    soft = SoftPixels(target, torch.ones(1, 4, 4))
    controls = Controls((*terms, soft), None, (1, 1), (4, 4), 1, "cpu")
    copied = controls.copied()
    assert copied[0, :, 0].tolist() == [5, 5, 9, -1]
    wish = controls.wish((copied >= 0).all(0))
    assert wish.weight[0, :, 0].tolist() == [0, 0, 0, 1]
    assert Controls(terms, None, (1, 1), (4, 4), 1, "cpu").wish((copied >= 0).all(0)) is None
    assert Controls((soft,), None, (1, 1), (4, 4), 1, "cpu").copied() is None


def test_pixels_that_are_copied_from_beyond_the_exemplar_are_refused():
    where, source = torch.ones(1, 16, 16, dtype=torch.bool), torch.full((2, 16, 16), 32)
    term = HardPixels(torch.zeros(1, 16, 16), where, source=source)
    with pytest.raises(InputError, match=r"copied from places up to \(32, 32\), but the exemplar's canvas"):
        optimize(Exemplar.of(torch.rand(1, 32, 32, generator=generator())), (16, 16), terms=term)
