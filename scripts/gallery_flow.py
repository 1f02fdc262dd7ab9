"""Flowing textures, after figures 29 to 34 of Kwatra's thesis, with exemplars that anyone may publish.

Problem: animate a texture by a flow field f, so that its elements move with the flow and keep their shape. Each frame
minimizes

    U(x) = U_t(x) + lambda (x - x+)^T K (x - x+),    x+(p) = x-(q), f(q) = p

its texture energy, and its difference from the frame before, x-, carried along the flow (equation 27).

Figure 36, and the four scenarios of section 7.2.1, are of videos: as published, with the energy

    U(x) = U_t(x) + lambda sum (x(p, i) - x(f_i(p), i + 1))^2                                        (equations 29, 30)

of the whole volume; and as `flow.animate` makes them, which carries texture along the flow while it lives on.

The exemplars are scikit-image's brick, gravel and coins, and stones, a keyboard, checkerboards and waves made here.
"""

import argparse
from collections.abc import Callable, Iterable
from pathlib import Path

import torch
import torch.nn.functional as F
from exemplars import brick, gravel, pebbles
from gallery_projection import checkerboard
from gallery_quilting import RGB, beside, picture, waves
from skimage import data
from torch import Tensor

import flow
from kwatra import Exemplar
from synth import write_image
from synth.sheets import video_sheet

KEY_FRAMES = (1, 9, 17, 25)
VIDEO_FRAMES = 12
FILLING_FRAMES = (9, 25, 41, 57)
SPEED = 2.0
FIELDS = {
    "sink": flow.sink(SPEED),
    "source": flow.source(SPEED),
    "rotation": flow.rotation(SPEED),
    "stream": flow.stream(SPEED, 20),
    "vortices": flow.vortices(SPEED),
}
VIDEO_FIELDS = (flow.uniform(1.0), flow.rotation(1.0), flow.vortices(1.0))
RED, BLUE = (0.85, 0.1, 0.1), (0.2, 0.3, 0.9)


def keyboard(side: int) -> Tensor:
    """Keys in rows, each with a mark of its own, (3, side, side)."""
    generator = torch.Generator().manual_seed(0)
    key = max(side // 7, 8)
    count = -(-side // key) + 1
    y, x = torch.meshgrid(torch.arange(side), torch.arange(side), indexing="ij")
    x = x + (y // key) * (key // 3)  # rows are staggered
    row, column, v, u = y // key, x // key % (2 * count), y % key, x % key
    rim = torch.stack([u, v, key - 1 - u, key - 1 - v]).amin(0)
    light = torch.where(rim < 1, 0.12, torch.where(rim < 3, 0.55, 0.8)) - 0.12 * (v / key) * (rim >= 3)
    marks = torch.rand(count, 2 * count, 5, 3, generator=generator) < 0.55
    cell = max(key // 9, 1)
    line, dot = (v - key // 4) // cell, (u - key // 4) // cell
    inked = marks[row, column, line.clamp(0, 4), dot.clamp(0, 2)] & (line >= 0) & (line < 5) & (dot >= 0) & (dot < 3)
    shade = torch.where(inked & (rim >= 3), 0.15, light)
    return torch.stack([shade, shade, 0.96 * shade + 0.02]).clamp(0, 1)


def coins(side: int) -> Tensor:
    """The upper coins of skimage's picture, (3, side, side)."""
    return picture(data.coins()[10:, 20:], side)


def colored(image: Tensor) -> Tensor:
    return image.expand(3, -1, -1)


def key_frames(
    exemplar: Tensor, field: flow.Field, size: int, numbers: Iterable[int] | None = None, **how: object
) -> list[flow.Frame]:
    """The frames, counted from 1, of a sequence of size x size px."""
    numbers = KEY_FRAMES if numbers is None else numbers
    frames = flow.animate(exemplar, field, (size, size), frames=max(numbers), **how)
    return [frame for number, frame in enumerate(frames, 1) if number in numbers]


def drawn(field: flow.Field, size: int) -> Tensor:
    return flow.picture(field(0, (size, size)), arrows=max(size // 8, 8))


def shown(frames: Iterable[flow.Frame]) -> Tensor:
    return beside(*[colored(frame.image) for frame in frames])


def under(*rows: Tensor, gap: int = 8) -> Tensor:
    """Pictures (3, H, W) under each other on white."""
    width = max(row.shape[2] for row in rows)
    padded = [F.pad(row, (0, width - row.shape[2], 0, gap), value=1.0) for row in rows]
    return torch.cat(padded, 1)[:, :-gap]


def figure_29(side: int) -> Tensor:
    """Five fields, and the last key-frame of two textures that follow them from one first frame: docs/flowing.jpg."""
    size = 3 * side // 2
    rows = [[key_frames(make(side), f, size)[-1] for f in FIELDS.values()] for make in (pebbles, brick)]
    return under(beside(*[drawn(field, size) for field in FIELDS.values()]), *map(shown, rows))


def along(field: flow.Field, side: int, *exemplars: Tensor) -> Tensor:
    """A field, and below it for each exemplar the exemplar and its key-frames."""
    size = 3 * side // 2
    rows = [beside(colored(exemplar), shown(key_frames(exemplar, field, size))) for exemplar in exemplars]
    return under(drawn(field, size), *rows)


def figure_30(side: int) -> Tensor:
    """Key-frames along a sink."""
    return along(FIELDS["sink"], side, keyboard(side), pebbles(side), gravel(side))


def figure_31(side: int) -> Tensor:
    """Key-frames along a stream."""
    return along(FIELDS["stream"], side, brick(side), pebbles(side), coins(side))


def figure_32(side: int) -> Tensor:
    """Rotation: above, the texture that is optimized; below, one that is only warped, with holes in white."""
    size, field = 3 * side // 2, FIELDS["rotation"]
    ours = key_frames(keyboard(side), field, size)
    look = flow.lookup(field(0, (size, size)))
    frame, there, warped = colored(ours[0].image), torch.ones(size, size, dtype=torch.bool), []
    for number in range(1, max(KEY_FRAMES) + 1):
        if number in KEY_FRAMES:
            warped.append(torch.where(there, frame, 1.0))
        frame = flow.warp(frame, look.coordinates)
        there = (flow.warp(there[None].float(), look.coordinates, "nearest")[0] > 0) & look.known
    return under(shown(ours), beside(*warped))


def figure_33(side: int) -> Tensor:
    """Texture that enters from the left and flows around an obstacle (red; blue: empty); below, the mask alone."""
    size = 3 * side // 2
    mask = flow.disc_mask((size, size), (0.5 * size, 0.5 * size), 0.16 * size)
    edge = (F.max_pool2d((~mask)[None].float(), 5, 1, 2)[0] > 0) & mask
    field = flow.around(flow.uniform(size / 36), mask)

    def painted(frame: flow.Frame, texture: bool) -> Tensor:
        image = colored(frame.image) if texture else torch.ones(3, size, size)
        for where, color in ((~frame.state.inside, BLUE), (edge, (1.0, 1.0, 1.0)), (~mask, RED)):
            image = torch.where(where, torch.tensor(color).view(3, 1, 1), image)
        return image

    exemplars = (pebbles(side), picture(data.grass(), side))
    rows = [key_frames(each, field, size, FILLING_FRAMES, mask=mask, enter="left") for each in exemplars]
    pictures = [beside(*[painted(frame, True) for frame in row]) for row in rows]
    return under(*pictures, beside(*[painted(frame, False) for frame in rows[0]]))


def figure_34(side: int) -> Tensor:
    """A checkerboard as it is, blurred, at half and at double scale: first frames, and along a sink and a source."""
    size, square = 3 * side // 2, side // 8
    board = checkerboard(side, square)
    smooth = F.avg_pool2d(F.pad(board, (2, 2, 2, 2), mode="replicate"), 5, 1)
    boards = [board, smooth, checkerboard(side, square // 2), checkerboard(side, 2 * square)]
    rows = []
    for name in ("sink", "source"):
        sequences = [key_frames(each, FIELDS[name], size, (1, max(KEY_FRAMES))) for each in boards]
        rows += [] if rows else [shown([first for first, _ in sequences])]
        rows.append(shown([last for _, last in sequences]))
    return under(*rows)


def pond(side: int) -> Tensor:
    """Waves that travel in many directions, (3, 12, side, side)."""
    return waves(12, side)


def in_time(frames: Iterable[flow.Frame]) -> Tensor:
    return torch.stack([frame.image for frame in frames], 1)


def figure_36(side: int) -> Tensor:
    """Fields, and a pond that follows them: as published and, below, carried while it lives on.

    Of each the first, middle and last frame, then the middle row and the middle column over time.
    """
    size, clip, rows = (side, side), pond(side), []
    for field in VIDEO_FIELDS:
        for how in (flow.published, flow.animate):
            video = in_time(how(clip, field, size, frames=VIDEO_FRAMES))
            rows.append(beside(drawn(field, side), video_sheet(video, 3)))
    return under(*rows)


def section_7(side: int) -> Tensor:
    """What can become of windows that overlap (7.2.1), under a flow to the right; each as a frame and slices in time.

    They agree, and flow as wanted: clouds that drift to the right. They agree, and do not flow so: clouds that drift
    down. They flow so, and do not agree: these clouds with turned variants, and much weight on the flow, blur. They do
    neither: the same without the copies. Below, these clouds carried along the flow while they live on.
    """
    size, field, noise = (side, side), flow.uniform(1.0), torch.Generator().manual_seed(0)
    wide = F.avg_pool2d(F.pad(torch.rand(1, 2 * side, 2 * side, generator=noise), (2, 2, 2, 2), mode="circular"), 5, 1)
    wide = ((wide - wide.amin()) / (wide.amax() - wide.amin())).expand(3, -1, -1)
    right, down = (
        torch.stack([wide.roll((t * row, t * column), (1, 2))[:, :side, :side] for t in range(12)], 1)
        for row, column in ((0, 1), (1, 0))
    )
    plain, turned = Exemplar.of(down), Exemplar.of(down, rotate=(90.0,))
    ways = [(Exemplar.of(right), 0.003), (plain, 0.0), (turned, 1.0), (plain, 1.0)]
    made = [in_time(flow.published(each, field, size, VIDEO_FRAMES, weight)) for each, weight in ways]
    made.append(in_time(flow.animate(down, field, size, frames=VIDEO_FRAMES)))
    return under(*[video_sheet(video, 3) for video in made])


FIGURES: tuple[Callable[[int], Tensor], ...] = (
    figure_29, figure_30, figure_31, figure_32, figure_33, figure_34, figure_36, section_7,
)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=128, help="side of the exemplars; frames have half as much again")
    parser.add_argument("--only", type=int, nargs="+", metavar="NUMBER", help="these figures alone, by number")
    parser.add_argument("--out", type=Path, default=Path("out/gallery_flow"), help="folder for the pictures")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    for figure in FIGURES:
        if arguments.only and int(figure.__name__.split("_")[1]) not in arguments.only:
            continue
        path = arguments.out / f"{figure.__name__}.png"
        write_image(path, figure(arguments.side).clamp(0, 1), RGB, overwrite=True)
        print(f"{path}: {figure.__doc__}", flush=True)


if __name__ == "__main__":
    main()
