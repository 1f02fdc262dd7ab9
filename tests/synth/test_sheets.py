"""Pictures of frames: what is where in them."""

import torch

from synth.sheets import GAP, column_in_time, contact_sheet, row_in_time, stacked, video_sheet


def test_frames_fill_rows_and_what_is_left_is_white() -> None:
    frames = [torch.full((3, 5, 7), number / 8) for number in range(4)]
    sheet = contact_sheet(frames, columns=3)
    assert sheet.shape == (3, 2 * 5 + GAP, 3 * 7 + 2 * GAP)
    for number in range(4):
        top, left = number // 3 * (5 + GAP), number % 3 * (7 + GAP)
        assert torch.equal(sheet[:, top : top + 5, left : left + 7], frames[number])
    assert bool((sheet[:, 5 : 5 + GAP] == 1).all())
    assert bool((sheet[:, 5 + GAP :, 7 + GAP :] == 1).all())


def test_slices_show_what_moves_as_slanted_lines() -> None:
    still = torch.zeros(1, 6, 8)
    still[..., 2] = 1
    moving = torch.stack([still.roll(t, 2) for t in range(4)], 1)
    assert row_in_time(moving)[0].argmax(1).tolist() == [2, 3, 4, 5]
    turned = moving.transpose(2, 3)
    assert column_in_time(turned)[0].argmax(0).tolist() == [2, 3, 4, 5]


def test_a_video_is_its_frames_above_its_slices() -> None:
    video = torch.rand(3, 10, 24, 30, generator=torch.Generator().manual_seed(0))
    sheet = video_sheet(video, count=4)
    assert sheet.shape == (3, 24 + GAP + 24, 4 * 30 + 3 * GAP)
    for place, number in enumerate((0, 3, 6, 9)):
        left = place * (30 + GAP)
        assert torch.equal(sheet[:, :24, left : left + 30], video[:, number])
    below = sheet[:, 24 + GAP :]
    assert torch.equal(below[:, :20:2, :30], row_in_time(video))
    assert torch.equal(below[:, 1:20:2, :30], row_in_time(video))
    assert torch.equal(below[:, :, 30 + GAP : 60 + GAP : 3], column_in_time(video))
    assert bool((below[:, :, 60 + GAP :] == 1).all())


def test_a_single_frame_and_a_long_video_have_sheets() -> None:
    for length, height in ((1, 2 * 16 + GAP), (100, 16 + GAP + 100)):
        assert video_sheet(torch.rand(1, length, 16, 12)).shape[1] == height


def test_pictures_are_stacked_on_white() -> None:
    sheet = stacked([torch.zeros(1, 2, 3), torch.zeros(1, 4, 5)])
    assert sheet.shape == (1, 6 + GAP, 5)
    assert int((sheet == 1).sum()) == 2 * 2 + GAP * 5
