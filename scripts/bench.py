"""Quality and cost of synthesis, exemplar by exemplar, beside the other programs found on PATH.

    python scripts/bench.py                               textures that come with scikit-image
    python scripts/bench.py list.txt --images textures    the images named in a file, one a line
    python scripts/bench.py --scaling --preset fast       cost and memory from 256x256 to 2048x2048
    python scripts/bench.py --costs                       seconds of presets, sizes, quilting and the command line

Every method gets the exemplar as the same 8-bit PNG file, and is measured on the 8-bit PNG file that it made. cpu is in
seconds of all threads: for this project inside the process, once it has been imported; for another program all that
it takes. The columns after it are those of kwatra.measure, the last the one to rank by: lower is better, but read
it with `copy`.
"""

import argparse
import json
import math
import multiprocessing
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np
import torch
from costs import child_seconds, costs
from tables import Row, carried_exemplars, eight_bit, exit_code, given_exemplars, print_table, progress, size
from torch import Tensor

from kwatra import InputError, measure
from synth import read_image, synthesize, write_image
from synth.quilting import QuiltSettings, quilt

FIGURES = ("cpu", "wall", "forward", "coverage", "wasserstein", "sharpness", "copy", "use", "overall")
SCALING_SIDES = (256, 512, 1024, 2048)
PATIENCE = 600
"""Seconds that another program may take."""


@dataclass(frozen=True)
class Rival:
    """Another program: its name, the executable to look for, and its command line.

    command: from the executable, the exemplar's file, the file to make, its height and width, and the seed.
    """

    name: str
    executable: str
    command: Callable[[str, Path, Path, tuple[int, int], int], list[str]]


def gmic(executable: str, exemplar: Path, output: Path, size: tuple[int, int], seed: int) -> list[str]:
    synthesis = ["syntexturize_matchpatch", f"{size[1]},{size[0]}"]
    return [executable, "-v", "-", str(exemplar), "srand", str(seed), *synthesis, "-o", str(output)]


RIVALS = (Rival("G'MIC", "gmic", gmic),)


Method = Callable[[Path, Path], tuple[float, float]]
"""Makes the second file from the first; returns cpu and wall seconds."""


def own_method(synthesis: Callable[[Tensor], Tensor]) -> Method:
    def make(exemplar: Path, output: Path) -> tuple[float, float]:
        picture = read_image(exemplar)
        cpu, wall = time.process_time(), time.perf_counter()
        image = synthesis(picture.pixels)
        took = time.process_time() - cpu, time.perf_counter() - wall
        write_image(output, image, picture.kind, overwrite=True)
        return took

    return make


def rival_method(rival: Rival, executable: str, size: tuple[int, int], seed: int) -> Method:
    def make(exemplar: Path, output: Path) -> tuple[float, float]:
        output.unlink(missing_ok=True)
        cpu, wall = child_seconds(), time.perf_counter()
        command = rival.command(executable, exemplar, output, size, seed)
        subprocess.run(command, check=True, capture_output=True, timeout=PATIENCE)
        return child_seconds() - cpu, time.perf_counter() - wall

    return make


def methods(arguments: argparse.Namespace) -> dict[str, Method]:
    """This project's optimizer and its graph-cut quilting, then the rivals that are there."""
    size, preset, seed = arguments.size, arguments.preset, arguments.seed
    found: dict[str, Method] = {
        "kwatra": own_method(lambda exemplar: synthesize(exemplar, size, preset=preset, seed=seed).image),
        "quilting": own_method(lambda exemplar: quilt(exemplar, size, QuiltSettings(seed=seed)).image),
    }
    for rival, executable in present_rivals(arguments):
        found[rival.name] = rival_method(rival, executable, arguments.size, arguments.seed)
    return found


def present_rivals(arguments: argparse.Namespace) -> Iterator[tuple[Rival, str]]:
    """The rivals asked for that are there, and where."""
    for rival in RIVALS if arguments.rivals else ():
        executable = shutil.which(rival.executable)
        if executable is None:
            print(f"{rival.name} is left out: there is no {rival.executable} on PATH", flush=True)
        else:
            yield rival, executable


def bench(exemplars: dict[str, Tensor], found: dict[str, Method], folder: Path) -> Iterator[Row]:
    """Run every method on every exemplar; files go to `folder`."""
    for done, (name, image) in enumerate(exemplars.items()):
        given = folder / f"{name}.png"
        write_image(given, image, eight_bit(image), overwrite=True)
        for method, make in found.items():
            progress(f"{done + 1}/{len(exemplars)} {name}: {method}")
            made = folder / f"{name}_{plain(method)}.png"
            try:
                cpu, wall = make(given, made)
                figures = measure(read_image(made).pixels, read_image(given).pixels)
            except (InputError, OSError, subprocess.SubprocessError) as error:
                print(f"{name}  {method} failed: {error}", flush=True)
                continue
            yield Row(name, method, made.name, {"cpu": cpu, "wall": wall, **figures})
    progress("")


def plain(method: str) -> str:
    return "".join(letter for letter in method.lower() if letter.isalnum())


def write_contact_sheet(folder: Path, exemplars: Iterable[str], rows: list[Row]) -> Path:
    """One line per exemplar: itself, then each method's image; all at the same scale, in color."""
    lines = [[f"{name}.png", *(row.file for row in rows if row.exemplar == name)] for name in exemplars]
    images = [[in_color(read_image(folder / file).pixels) for file in files] for files in lines]
    heights = [max(image.shape[1] for image in each) for each in images]
    widths = [max(each[k].shape[2] for each in images if k < len(each)) for k in range(max(map(len, images)))]
    sheet = torch.ones(3, sum(heights) + 8 * len(heights), sum(widths) + 8 * len(widths))
    top = 0
    for each, height in zip(images, heights, strict=True):
        for k, image in enumerate(each):
            left = sum(widths[:k]) + 8 * k
            sheet[:, top : top + image.shape[1], left : left + image.shape[2]] = image
        top += height + 8
    path = folder / "contact_sheet.png"
    write_image(path, sheet, eight_bit(sheet), overwrite=True)
    return path


def in_color(image: Tensor) -> Tensor:
    return image[:3] if image.shape[0] >= 3 else image[:1].expand(3, -1, -1)


def scaling(exemplar: Tensor, preset: str, seed: int) -> Iterator[dict[str, float]]:
    """Cost of square outputs of rising size, each in a process of its own, so that its peak memory is its own."""
    context = multiprocessing.get_context("spawn")
    for side in SCALING_SIDES:
        progress(f"{side}x{side}")
        with ProcessPoolExecutor(max_workers=1, mp_context=context) as pool:
            yield pool.submit(cost, exemplar.numpy(), side, preset, seed).result()
    progress("")


def cost(exemplar: np.ndarray, side: int, preset: str, seed: int) -> dict[str, float]:
    """Seconds, microseconds per output pixel, and peak memory of one synthesis in this process."""
    image = torch.from_numpy(exemplar)
    cpu, wall = time.process_time(), time.perf_counter()
    synthesize(image, (side, side), preset=preset, seed=seed)
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)
    return {"side": side, "cpu": cpu, "wall": wall, "cpu per pixel (us)": cpu / side**2 * 1e6, "peak (MiB)": peak}


def print_scaling(name: str, costs: Iterable[dict[str, float]]) -> list[dict[str, float]]:
    """Print costs as they come; returns them."""
    kept: list[dict[str, float]] = []
    for each in costs:
        progress("")
        if not kept:
            print(f"from {name}:\n" + "  ".join(column.rjust(10) for column in each))
        print("  ".join(f"{value:.4g}".rjust(max(10, len(column))) for column, value in each.items()), flush=True)
        kept.append(each)
    return kept


def print_costs(name: str, exemplar: Tensor, arguments: argparse.Namespace) -> dict[str, float]:
    """Print what it all costs; returns the figures."""
    arguments.out.mkdir(parents=True, exist_ok=True)
    given, made = arguments.out / f"{name}.png", arguments.out / "made.png"
    write_image(given, exemplar, eight_bit(exemplar), overwrite=True)

    def taken(rival: Rival, executable: str, side: int) -> float:
        try:
            return rival_method(rival, executable, (side, side), arguments.seed)(given, made)[0]
        except (OSError, subprocess.SubprocessError):
            return math.nan

    rivals = {rival.name: partial(taken, rival, executable) for rival, executable in present_rivals(arguments)}
    figures = {}
    print(f"from {name}, cpu seconds on one thread:")
    for what, figure in costs(exemplar, given, arguments.size[0], rivals):
        figures[what] = figure
        print(f"{what:40}{figure:8.2f}", flush=True)
    return figures


def parsed(words: list[str] | None) -> argparse.Namespace:
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("exemplars", nargs="*", help="image files, names, or text files that list them")
    parser.add_argument("--images", type=Path, default=Path(), help="folder where names, with .png, are looked for")
    parser.add_argument("--size", type=size, default=(256, 256), help="of the outputs, WIDTHxHEIGHT (256x256)")
    parser.add_argument("--preset", choices=("fast", "default", "best"), default="default")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="folder for the images (out/bench)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too")
    parser.add_argument(
        "--rivals", action=argparse.BooleanOptionalAction, default=True, help="run other programs found on PATH"
    )
    parser.add_argument("--scaling", action="store_true", help="cost by output size, from the first exemplar")
    parser.add_argument("--costs", action="store_true", help="cost of all presets, from the first exemplar")
    return parser.parse_args(words)


def run(arguments: argparse.Namespace) -> None:
    exemplars = given_exemplars(arguments.exemplars, arguments.images) if arguments.exemplars else carried_exemplars()
    name = next(iter(exemplars))
    if arguments.costs:
        figures = print_costs(name, exemplars[name], arguments)
    elif arguments.scaling:
        figures = print_scaling(name, scaling(exemplars[name], arguments.preset, arguments.seed))
    else:
        arguments.out.mkdir(parents=True, exist_ok=True)
        found = methods(arguments)
        rows = print_table(bench(exemplars, found, arguments.out), FIGURES, max(map(len, exemplars)))
        figures = [asdict(row) for row in rows]
        print(f"images side by side: {write_contact_sheet(arguments.out, exemplars, rows)}")
    if arguments.json is not None:
        arguments.json.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


def main(words: list[str] | None = None) -> int:
    arguments = parsed(words)
    return exit_code("bench", lambda: run(arguments))


if __name__ == "__main__":
    sys.exit(main())
