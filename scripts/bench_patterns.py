"""How well patterns are detected: made textures of discs and crosses, whose every landmark is known.

A pattern is found if the centroid of one that was detected lies within 3 px of it; what is found elsewhere is wrong.
The error of its landmarks is their mean distance to the known ones; of discs, which look the same turned, along the
radius only.

    python scripts/bench_patterns.py [--textures 6] [--noise 0.08,0.15]
"""

import argparse
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.metamorphosis.patterns import detect

Array = NDArray[np.float64]
RADIUS, CONTRAST, NEAR = 9.0, 0.4, 3.0


@dataclass(frozen=True)
class Made:
    """A made texture (H, W, 3) and the landmarks (n, 12, 2) of its patterns."""

    image: Array
    landmarks: Array


def made(kind: str, seed: int = 0, size: int = 192, pitch: int = 32, noise: float = 0.08) -> Made:
    """Discs or crosses of radius 9, up to 4 px off a lattice, turned by 10 degrees, scaled by a tenth; some lack."""
    random = np.random.default_rng(seed)
    image = np.full((size, size), 0.35)
    rows = np.arange(pitch / 2 + 2, size - RADIUS - 3, pitch)
    every = []
    for place in [(x, y) for y in rows for x in rows]:
        if random.random() < 0.15:
            continue
        center = place + random.uniform(-4, 4, 2)
        scale, angle = random.uniform(0.9, 1.1), np.deg2rad(random.uniform(-10, 10))
        turn = scale * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        image += CONTRAST * covered(kind, center, turn, size)
        every.append(outline(kind) @ turn.T + center)
    image = np.clip(image + random.normal(0, noise, image.shape), 0, 1)
    return Made(np.repeat(image[..., None], 3, 2), np.array(every))


def covered(kind: str, center: Array, turn: Array, size: int) -> Array:
    """How much of each pixel (size, size) a shape at a center covers, `turn` (2, 2) being its turn and scale."""
    grid = np.stack(np.meshgrid(np.arange(size), np.arange(size)), -1) - center
    x, y = np.moveaxis(np.abs(grid @ np.linalg.inv(turn).T), -1, 0)
    arm = 0.35 * RADIUS
    bars = np.minimum(np.maximum(x - arm, y - RADIUS), np.maximum(x - RADIUS, y - arm))
    beyond = np.hypot(x, y) - RADIUS if kind == "disc" else bars
    return np.clip(0.5 - beyond, 0, 1)


def outline(kind: str) -> Array:
    """The 12 landmarks (12, 2) of a shape at the origin."""
    if kind == "disc":
        angles = np.arange(12) / 6 * np.pi
        return RADIUS * np.stack([np.cos(angles), np.sin(angles)], 1)
    long, arm = RADIUS, 0.35 * RADIUS
    quarter = np.array([(arm, -long), (arm, -arm), (long, -arm)])
    turned = [quarter, quarter[:, ::-1] * [-1, 1], -quarter, quarter[:, ::-1] * [1, -1]]
    return np.concatenate(turned)


def measured(kind: str, seed: int, noise: float) -> dict[str, float]:
    """Counts of patterns that are there, found and wrong, and the landmarks' mean and worst errors in px."""
    truth = made(kind, seed, noise=noise)
    found = detect(truth.image, truth.landmarks[0]).landmarks
    away = np.linalg.norm(found.mean(1)[:, None] - truth.landmarks.mean(1)[None], axis=2)
    hits = np.flatnonzero(away.min(0) < NEAR)
    errors = [_error(kind, found[away[:, number].argmin()], truth.landmarks[number]) for number in hits]
    wrong = int((away.min(1) >= NEAR).sum())
    return {"there": len(truth.landmarks), "found": len(hits), "wrong": wrong, "error": float(np.mean(errors)),
            "worst": float(np.max(errors))}  # fmt: skip


def _error(kind: str, found: Array, truth: Array) -> float:
    if kind == "disc":
        center = truth.mean(0)
        away = np.linalg.norm(found - center, axis=1) - np.linalg.norm(truth - center, axis=1)
        return float(np.abs(away).mean())
    return float(np.linalg.norm(found - truth, axis=1).mean())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--textures", type=int, default=6)
    parser.add_argument("--noise", default="0.08,0.15")
    arguments = parser.parse_args()
    print("kind   noise  patterns  found  wrong  landmark error, px (worst pattern)")
    for kind in ("disc", "cross"):
        for noise in map(float, arguments.noise.split(",")):
            rows = [measured(kind, seed, noise) for seed in range(arguments.textures)]
            there, found, wrong = (sum(row[key] for row in rows) for key in ("there", "found", "wrong"))
            error, worst = np.mean([row["error"] for row in rows]), max(row["worst"] for row in rows)
            print(f"{kind:6} {noise:5.2f}  {there:8} {found / there:6.1%} {wrong / max(1, found + wrong):6.1%}  "
                  f"{error:.2f} ({worst:.2f})")  # fmt: skip


if __name__ == "__main__":
    main()
