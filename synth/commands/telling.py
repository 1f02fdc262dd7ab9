"""What commands say when they are done: a line for people, and details for those who want them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from torch import Tensor

    from kwatra import Result
    from synth.io import Array


def contributions(paths: Sequence[Path], source: "Array") -> str:
    """What part of an output comes from each of several exemplars: source (H, W) is their number, -1 for none."""
    told = Contributions(paths)
    told.add(source)
    return told.said()


class Contributions:
    """What part of an output that is made frame by frame comes from each of several exemplars."""

    def __init__(self, paths: Sequence[Path]) -> None:
        self._paths, self._counts, self._all = paths, [0] * len(paths), 0

    def add(self, source: "Array") -> None:
        """Count a frame: source (H, W) is the number of each pixel's exemplar, -1 for none."""
        import numpy as np

        if len(self._paths) < 2:
            return  # of one there is nothing to tell
        pixels = np.bincount(source[source >= 0].ravel(), minlength=len(self._paths))
        self._counts = [before + int(count) for before, count in zip(self._counts, pixels, strict=True)]
        self._all += source.size

    def said(self) -> str:
        """The parts, to follow a summary; nothing where there is one exemplar, or no frame."""
        if not self._all:
            return ""
        parts = [
            f"{path.name} {_percent(count / self._all)}" for path, count in zip(self._paths, self._counts, strict=True)
        ]
        return f"; of it {', '.join(parts)}"


def details(rows: Mapping[str, object]) -> str:
    """Further lines of a summary: what, and its value."""
    width = max(map(len, rows))
    return "".join(f"\n  {name.ljust(width)}  {value}" for name, value in rows.items())


def of_result(result: "Result") -> dict[str, object]:
    """How an optimization went: where there was nothing to iterate, why it ended."""
    if not result.energies:
        return {"ended because": result.stopped}
    levels = dict.fromkeys(f"1/{stage.factor} with windows of {stage.width}" for stage in result.stages)
    named = [f"{name} {value:.4g}" for name, value in result.energies[-1].items()
             if name not in ("level", "factor", "width", "iteration", "route", "changed", "residual")]  # fmt: skip
    return {"levels": ", ".join(levels), "iterations": len(result.energies), "energy": ", ".join(named),
            "ended because": result.stopped}  # fmt: skip


def about(output: "Tensor", exemplars: "Sequence[Tensor]") -> str:
    """About how good an output (C, H, W) is, at little cost; nothing where that cannot be told."""
    from kwatra.scoring import glance

    if not _measurable(output, exemplars):
        return ""
    return f", quality about {glance(output, exemplars):.2f} (0 is best)"


def quality(output: "Tensor", exemplars: "Sequence[Tensor]") -> dict[str, object]:
    """How good an output (C, H, W) is, as `kwatra score` says it; nothing where that cannot be told."""
    from kwatra import measure

    if not _measurable(output, exemplars):
        return {}
    figures = measure(output, list(exemplars))
    rest = ", ".join(f"{name} {value:.3f}" for name, value in figures.items() if name != "overall")
    return {"quality": f"overall {figures['overall']:.3f} (0 is best; {rest})"}


def _measurable(output: "Tensor", exemplars: "Sequence[Tensor]") -> bool:
    from kwatra.scoring import CHANNELS, WINDOW

    return len(output) <= CHANNELS and min(min(image.shape[1:]) for image in (output, *exemplars)) >= WINDOW


def _percent(part: float) -> str:
    return "nothing" if part == 0 else "under 1%" if part < 0.01 else f"{part:.0%}"
