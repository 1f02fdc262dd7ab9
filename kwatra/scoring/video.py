"""How good a video texture is, in figures.

Videos are alike as textures when their windows in space and time are alike, and when they move alike. Windows are 4
frames of 7 x 7 pixels at the scales 1 and 4; distances are as those of images.

    forward       mean distance from the output's windows to the nearest of the exemplar's: is what is seen, and how it
                  goes on, plausible?
    coverage      the same from the exemplar's windows to the output's: does everything happen?
    wasserstein   sliced Wasserstein distance between the sets of windows, in the exemplar's principal components, each
                  in its own deviations, so that faint motion counts like light and shade: does it happen as often?
    sharpness     mean absolute gradient, output / exemplar: 1 is right, below is blur.
    change        mean absolute change per frame, output / exemplar: 1 is right, 0 a still, above is restless.
    flicker       mean absolute change of the change, output / exemplar: 1 is right, above is flicker.
    tempo, order, direction   see `motion`: how fast things change, whether frames follow from each other, whether they
                  go the exemplar's way. 0 is right.
    replay        part of what moves that is a clip of the exemplar played again, 8 frames or longer: lower is newer.
    loop          rms step from the last frame to the first over the exemplar's largest: at most 1 joins without a jerk;
                  means nothing where no loop was asked for.
    overall       mean of forward, coverage, wasserstein, tempo, order, direction, and what sharpness and change are off
                  1, each at most 1: lower is better, to be read with `replay`.
"""

from collections.abc import Sequence

from torch import Tensor

from kwatra.scoring.motion import Variogram, count_of_bands, direction, order, tempo
from kwatra.scoring.nearest import QUERIES, WINDOW, Nearest, Windows
from kwatra.scoring.pixels import change, gradient, ratio, unit
from kwatra.scoring.replay import replay
from kwatra.scoring.sliced import sliced_distance

FIGURES = (
    "forward", "coverage", "wasserstein", "sharpness", "change", "flicker", "tempo", "order", "direction", "replay",
    "loop", "overall",
)  # fmt: skip

DEPTH = 4
"""Frames of a window, as the engine has them."""

SCALES = (1, 4)
"""Of those that images have; leaving the one between out saves a third and left ten spoilt waterfalls ranked alike."""


def video_figures(output: Tensor, exemplars: Sequence[Tensor], carried: Sequence[int]) -> dict[str, float]:
    """The figures above of a video (C, T, H, W) against one or several; `carried`: the scales that fit into all.

    Shorter clips than windows are long make these as short.
    """
    depth = min(DEPTH, output.shape[1], *(clip.shape[1] for clip in exemplars))
    distances = [_distances(output, exemplars, scale, depth) for scale in SCALES if scale in carried]
    figures = {name: sum(each[name] for each in distances) / len(distances) for name in distances[0]}
    figures["replay"] = distances[0]["replay"]
    figures["sharpness"] = ratio(gradient([output]), gradient(exemplars))
    figures["change"], figures["flicker"] = (ratio(change([output], n), change(exemplars, n)) for n in (1, 2))
    bands = count_of_bands([output, *exemplars])
    ours, theirs = Variogram.of([output], bands), Variogram.of(exemplars, bands)
    figures |= {"tempo": tempo(ours, theirs), "order": order(ours, theirs), "direction": direction(ours, theirs)}
    figures["loop"] = _join(output, exemplars)
    parts = [figures[name] for name in ("forward", "coverage", "wasserstein", "tempo", "order", "direction")]
    parts += [abs(1 - figures[name]) for name in ("sharpness", "change")]
    figures["overall"] = sum(min(part, 1.0) for part in parts) / len(parts)
    return {name: figures[name] for name in FIGURES}


def _distances(output: Tensor, exemplars: Sequence[Tensor], scale: int, depth: int) -> dict[str, float]:
    """forward, coverage and wasserstein at a scale, and replay, which only the first scale can tell."""
    ours, theirs = (Windows.of(side, WINDOW, scale, depth) for side in ([output], exemplars))
    our_numbers, their_numbers = (windows.sample(QUERIES) for windows in (ours, theirs))
    likest = Nearest(theirs)
    forward, found = likest.search(ours.rows(our_numbers))
    coverage, _ = Nearest(ours, likest).search(theirs.rows(their_numbers))
    samples = (windows.rows(windows.sample(4 * QUERIES)) for windows in (ours, theirs))
    return {
        "forward": float(forward.mean()) / unit(exemplars),
        "coverage": float(coverage.mean()) / unit(exemplars),
        "wasserstein": sliced_distance(*map(likest.project.whitened, samples)),
        "replay": replay(ours, our_numbers, theirs, found) if scale == 1 else 0.0,
    }


def _join(output: Tensor, exemplars: Sequence[Tensor]) -> float:
    """Rms step from the last frame to the first over the largest step of an exemplar."""
    step = float((output[:, 0] - output[:, -1]).square().mean().sqrt())
    steps = [clip.diff(dim=1).square().mean((0, 2, 3)).sqrt() for clip in exemplars]
    return ratio(step, max((float(each.max()) for each in steps if len(each)), default=0.0))
