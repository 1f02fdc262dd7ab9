"""Textures made in code, of which is known which element each pixel belongs to: stones, rubble, granite, mosaics,
coins, buttons, tiles, bricks, courses, letters, beaches, patches, confetti.

Elements are all of about one size, but for buttons, and apart by a ground at least two pixels wide; those of the last
two touch.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import torch
from PIL import Image, ImageDraw, ImageFont
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree
from skimage.measure import label
from torch import Tensor

GROUND = 0
CONNECTED = "abcdefghklmnopqrstuvwxyz"
"""Letters that are of one piece."""


class Made(NamedTuple):
    """image (3, H, W) float32 in [0, 1]; numbers (H, W) int64: of the element a pixel belongs to, 0 for the ground.

    touching: whether elements lie beside or upon each other, with no ground between them.
    """

    image: Tensor
    numbers: Tensor
    touching: bool = False


def stones(side: int, size: float, seed: int = 0) -> Made:
    """Stones `size` pixels across that fill the picture, of one brightness and many colors, darker towards the gaps."""
    rng = np.random.default_rng(seed)
    count, cells, apart = _cells(side, size, rng)
    depth, gap = apart / 2, max(0.05 * size, 1.0)
    shade = np.clip(0.25 + 0.75 * depth / (3 * gap), 0.25, 1.0)
    speckle = gaussian_filter(rng.normal(0, 1, (side, side)), 0.7) * 0.08
    image = (_colors(count, rng)[cells[0]] + speckle[..., None]) * shade[..., None]
    return _made(image, np.where(depth > gap, cells[0] + 1, GROUND))


def rubble(side: int, size: float, seed: int = 0) -> Made:
    """Stones `size` pixels across that fill the picture, of many brightnesses, apart by thin shaded joints."""
    rng = np.random.default_rng(seed)
    count, cells, apart = _cells(side, size, rng)
    depth = apart / 2
    shade = 0.25 + 0.75 * np.clip(depth / (0.1 * size), 0, 1) ** 0.6
    tone = np.array([0.5, 0.45, 0.4]) + rng.uniform(-0.15, 0.15, (count, 1)) + rng.uniform(-0.05, 0.05, (count, 3))
    speckle = 1 + gaussian_filter(rng.normal(0, 1, (side, side)), 1.0) * 0.12
    image = tone[cells[0]] * (speckle * shade)[..., None]
    return _made(image, np.where(depth > max(0.04 * size, 1.0), cells[0] + 1, GROUND))


def granite(side: int, size: float, seed: int = 0) -> Made:
    """Stones `size` pixels across that fill the picture, of one color and much grain, parted by thin dark lines."""
    rng = np.random.default_rng(seed)
    count, cells, apart = _cells(side, size, rng)
    wide = gaussian_filter(rng.normal(0, 1, (side, side)), 6)
    on = _step(apart / 2 - 1.3 - 0.45 * wide / wide.std())
    tone = np.array([0.5, 0.45, 0.4]) + rng.normal(0, 0.04, (count, 1))
    grain = gaussian_filter(rng.normal(0, 1, (side, side)), 0.5)
    image = (on * tone[cells[0]] + (1 - on) * 0.18) * (1 + 0.22 * grain / grain.std())[..., None]
    return _made(image, np.where(apart > 2, cells[0] + 1, GROUND))


def mosaic(side: int, size: float, seed: int = 0) -> Made:
    """Flat stones `size` pixels across in four colors, apart by thin joints that are as bright as some of them."""
    rng = np.random.default_rng(seed)
    count, cells, apart = _cells(side, size, rng)
    gap = max(0.08 * size, 2.0)
    on = _step(apart - gap)
    colors = _bright(count, rng)
    grain = rng.normal(0, 0.02, (side, side, 1))
    image = on * (colors[cells[0]] + grain) + (1 - on) * 0.45
    return _made(image, np.where(apart > gap, cells[0] + 1, GROUND))


def patches(side: int, size: float, seed: int = 0) -> Made:
    """Flat stones as those of `mosaic`, without joints."""
    rng = np.random.default_rng(seed)
    count, cells, apart = _cells(side, size, rng)
    colors, share = _bright(count, rng), _step(apart)
    grain = rng.normal(0, 0.02, (side, side, 1))
    return _made(share * colors[cells[0]] + (1 - share) * colors[cells[1]] + grain, cells[0] + 1, touching=True)


def confetti(side: int, size: float, seed: int = 0) -> Made:
    """Ellipses `size` pixels long in four colors that lie upon each other and cast shadows, on white paper.

    What is seen of one in two places is two elements.
    """
    rng = np.random.default_rng(seed)
    image, numbers = np.full((side, side, 3), 0.95), np.full((side, side), GROUND)
    count = round(4 * (side + size) ** 2 / size**2)
    for number, color in enumerate(_bright(count, rng), 1):
        center, angle, width = rng.uniform(-size / 2, side + size / 2, 2), rng.uniform(0, np.pi), rng.uniform(0.6, 1)
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) / [[1], [width]]
        inside, behind = (
            size / 2 - np.linalg.norm((_pixels(side) - center - off) @ turn.T, axis=1).reshape(side, side)
            for off in (0, 0.1 * size)
        )
        on = _step(inside)
        image = on * color + (1 - on) * image * (1 - 0.3 * _step(behind / 2))
        numbers = np.where(inside > 0, number, numbers)
    return _made(image, label(numbers, background=GROUND), touching=True)


def coins(side: int, size: float, seed: int = 0) -> Made:
    """Round coins `size` pixels across, apart on dark cloth; a coin and its gap take 1.25 sizes."""
    rng = np.random.default_rng(seed)
    centers = _evenly_scattered(side, 1.25 * size, rng)
    distance, owner = (found.reshape(side, side) for found in cKDTree(centers).query(_pixels(side)))
    spacing, _ = cKDTree(centers).query(centers, k=2)
    radius = np.minimum(size / 2, spacing[:, 1] / 2 - 1)[owner]
    on = distance < radius
    tone = rng.uniform(0.55, 0.95, len(centers))[owner] * (1 - 0.35 * (distance > 0.8 * radius))
    metal = tone[..., None] * np.array([1.0, 0.85, 0.55])
    cloth = 0.12 + gaussian_filter(rng.normal(0, 1, (side, side)), 0.7)[..., None] * 0.05
    return _made(np.where(on[..., None], metal, cloth), np.where(on, owner + 1, GROUND))


def buttons(side: int, size: float, seed: int = 0) -> Made:
    """Buttons with four holes each, some `size` pixels across and some two thirds of that, apart on rough cloth."""
    rng = np.random.default_rng(seed)
    rough = gaussian_filter(rng.normal(0, 1, (side, side)), 0.7)[..., None] * 0.05
    image, numbers = np.array([0.3, 0.35, 0.5]) + rough, np.full((side, side), GROUND)
    down, right = np.mgrid[:side, :side]
    kept = list[tuple[float, float, float]]()
    for _ in range(round(100 * (side / size) ** 2)):
        radius, (row, column) = size / rng.choice([2, 3]), rng.uniform(-size / 2, side + size / 2, 2)
        if any(np.hypot(row - y, column - x) < radius + other + 2 for y, x, other in kept):
            continue
        kept.append((row, column, radius))
        off = np.hypot(down - row, right - column)
        color = np.array([[0.85, 0.3, 0.3], [0.9, 0.85, 0.7], [0.35, 0.6, 0.4], [0.9, 0.7, 0.25]])[rng.integers(4)]
        ring = 0.75 + 0.25 * np.cos(1.5 * np.pi * off / radius)
        hole = np.hypot(np.abs(down - row) - 0.22 * radius, np.abs(right - column) - 0.22 * radius) < 0.12 * radius
        image = np.where((off < radius)[..., None], np.where(hole, 0.1, ring)[..., None] * color, image)
        numbers[off < radius] = len(kept)
    return _made(image, numbers)


def tiles(side: int, size: float, seed: int = 0) -> Made:
    """Square tiles in many colors with light joints, a tile and its joint `size` pixels wide."""
    rng = np.random.default_rng(seed)
    step, joint = round(size), max(round(0.08 * size), 2)
    row, column = np.divmod(np.arange(side), step)[0], np.arange(side) % step
    on = (column[:, None] >= joint) & (column >= joint)
    numbers = row[:, None] * (row.max() + 1) + row
    grain = gaussian_filter(rng.normal(0, 1, (side, side)), 0.7)[..., None] * 0.04
    image = np.where(on[..., None], _colors(numbers.max() + 1, rng)[numbers], 0.9) + grain
    return _made(image, np.where(on, numbers + 1, GROUND))


def bricks(side: int, size: float, seed: int = 0) -> Made:
    """A wall of dark bricks twice as long as high, courses half a brick apart, in rough light mortar.

    A brick and its joints have the area of a square of `size` pixels.
    """
    rng = np.random.default_rng(seed)
    high, joint = round(size / 2**0.5), max(round(0.1 * size), 2)
    row, below = np.divmod(np.arange(side), high)
    column, beside = np.divmod(np.arange(side) + (row % 2 * high)[:, None], 2 * high)
    on = (below[:, None] >= joint) & (beside >= joint)
    numbers = row[:, None] * (column.max() + 1) + column
    rough, grain = (gaussian_filter(rng.normal(0, 1, (side, side)), sigma) for sigma in (1.0, 0.7))
    shade = 0.35 + rng.uniform(-0.05, 0.05, numbers.max() + 1)[numbers] + 0.08 * grain
    image = np.where(on, shade, 0.75 + 0.45 * rough)[..., None] * np.array([1.0, 0.8, 0.7])
    return _made(image, np.where(on, numbers + 1, GROUND))


def courses(side: int, size: float, seed: int = 0) -> Made:
    """A wall of bricks of many lengths, 1.3 to 2.5 times their height, in plain light mortar.

    A usual brick and its joints have the area of a square of `size` pixels.
    """
    rng = np.random.default_rng(seed)
    high, joint = round(size / 1.9**0.5), max(round(0.12 * size), 2)
    numbers, row, below = np.zeros((side, side), np.int64), *np.divmod(np.arange(side), high)
    for course in range(row.max() + 1):
        ends = np.cumsum(rng.integers(round(1.3 * high), round(2.5 * high) + 1, side // high + 2)) - rng.integers(high)
        brick = np.searchsorted(ends, np.arange(side), "right")
        on = (np.arange(side) < ends[brick] - joint) & (below[row == course, None] >= joint)
        numbers[row == course] = np.where(on, numbers.max() + 1 + brick, GROUND)
    tone = rng.uniform(0.35, 0.75, numbers.max() + 1)[numbers][..., None] * np.array([1.0, 0.55, 0.45])
    grain = gaussian_filter(rng.normal(0, 1, (side, side)), 0.7)[..., None] * 0.03
    mortar = np.array([0.75, 0.72, 0.68])
    return _made(np.where(numbers[..., None] > GROUND, tone, mortar) + grain, numbers)


def letters(side: int, size: float, seed: int = 0) -> Made:
    """Rows of black letters on white, `size` pixels high."""
    rng = np.random.default_rng(seed)
    font = ImageFont.load_default(size=size)
    image, numbers = np.ones((side, side)), np.zeros((side, side), dtype=np.int64)
    for top in range(0, side, round(1.2 * size)):
        left = 0
        while left < side:
            letter = CONNECTED[rng.integers(len(CONNECTED))]
            page = Image.new("L", (side, side), 255)
            ImageDraw.Draw(page).text((left, top), letter, fill=0, font=font)
            ink = np.asarray(page) / 255
            numbers = np.where(ink < 0.85, numbers.max() + 1, numbers)
            image = np.minimum(image, ink)
            left += round(font.getlength(letter)) + 2
    return _made(np.repeat(image[..., None], 3, 2), numbers)


def beach(side: int, size: float, seed: int = 0) -> Made:
    """Smooth pebbles `size` pixels long, apart on sand that is as dark as some of them and as light as others."""
    rng = np.random.default_rng(seed)
    centers = _evenly_scattered(side, 1.4 * size, rng)
    apart, _ = cKDTree(centers).query(centers, k=2)
    _, owner = cKDTree(centers).query(_pixels(side))
    length, angle = np.minimum(size, apart[:, 1] - 2) / 2, rng.uniform(0, np.pi, len(centers))
    turned = np.exp(1j * angle)[owner] * ((_pixels(side) - centers[owner]) @ [1, 1j])
    across = rng.uniform(0.65, 1, len(centers))[owner]
    far = (np.hypot(turned.real, turned.imag / across) / length[owner]).reshape(side, side)
    grain, speckle, drift = (gaussian_filter(rng.normal(0, 1, (side, side)), sigma) for sigma in (0.8, 0.8, 4.0))
    sand = (0.55 + 0.26 * grain + 0.7 * drift)[..., None] * np.array([1.0, 0.88, 0.68])
    tone = rng.choice([0.3, 0.45, 0.75], (len(centers), 1)) * rng.uniform(0.8, 1.15, (len(centers), 3))
    color = tone[owner].reshape(side, side, 3) * (1.1 - 0.4 * far**2 + 0.1 * speckle)[..., None]
    on = _step((1 - far) * size / 2)
    return _made(on * color + (1 - on) * sand, np.where(far < 1, owner.reshape(side, side) + 1, GROUND))


MADE: dict[str, Callable[..., Made]] = {
    "stones": stones,
    "rubble": rubble,
    "mosaic": mosaic,
    "coins": coins,
    "buttons": buttons,
    "tiles": tiles,
    "bricks": bricks,
    "courses": courses,
    "granite": granite,
    "letters": letters,
    "beach": beach,
    "patches": patches,
    "confetti": confetti,
}
"""By name: what makes a texture of some side, from elements of some size."""


def _made(image: np.ndarray, numbers: np.ndarray, touching: bool = False) -> Made:
    pixels = torch.from_numpy(np.clip(image, 0, 1).astype(np.float32)).movedim(2, 0)
    return Made(pixels.contiguous(), torch.from_numpy(numbers.astype(np.int64)), touching)


def _pixels(side: int) -> np.ndarray:
    return np.stack(np.mgrid[:side, :side], -1).reshape(-1, 2)


def _step(inside: np.ndarray) -> np.ndarray:
    """0 to 1 (..., 1) across a border, given by how many pixels places lie within it."""
    return 1 / (1 + np.exp(np.clip(-inside / 0.7, -50, 50)))[..., None]


def _cells(side: int, size: float, rng: np.random.Generator) -> tuple[int, np.ndarray, np.ndarray]:
    """How many cells there are, those nearest and second nearest to each pixel (2, H, W), and how much nearer it is."""
    centers = _evenly_scattered(side, size, rng)
    distance, owner = cKDTree(centers).query(_pixels(side), k=2)
    return len(centers), owner.T.reshape(2, side, side), (distance[:, 1] - distance[:, 0]).reshape(side, side)


def _bright(count: int, rng: np.random.Generator) -> np.ndarray:
    """Colors (count, 3) about four that are far apart."""
    palette = np.array([[0.2, 0.4, 0.7], [0.9, 0.8, 0.2], [0.8, 0.2, 0.3], [0.2, 0.6, 0.4]])
    return palette[rng.integers(4, size=count)] + rng.normal(0, 0.04, (count, 3))


def _colors(count: int, rng: np.random.Generator) -> np.ndarray:
    """Colors (count, 3) of one brightness."""
    color = rng.uniform(-0.3, 0.3, (count, 3))
    return 0.55 + color - color @ np.array([0.299, 0.587, 0.114])[:, None]


def _evenly_scattered(side: int, distance: float, rng: np.random.Generator) -> np.ndarray:
    """Points about `distance` apart, on the picture and around it: random ones, relaxed (Lloyd)."""
    span = (-distance, side + distance)
    points = rng.uniform(*span, (int((span[1] - span[0]) ** 2 / (0.92 * distance**2)), 2))
    sample = rng.uniform(*span, (100 * len(points), 2))
    for _ in range(12):
        _, owner = cKDTree(points).query(sample)
        count = np.bincount(owner, minlength=len(points))
        sums = np.stack([np.bincount(owner, sample[:, axis], len(points)) for axis in (0, 1)], 1)
        points = np.where(count[:, None] > 0, sums / np.maximum(count, 1)[:, None], points)
    return points
