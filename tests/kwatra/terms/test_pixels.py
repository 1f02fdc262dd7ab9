import pytest
import torch

from kwatra import HardPixels, InputError, SoftPixels


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
