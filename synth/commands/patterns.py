"""`kwatra patterns`: the patterns of a texture, found or completed, as a file to edit and a picture to look at."""

import argparse
from pathlib import Path
from typing import Any

from synth.commands.parsing import positive

_EPILOG = """examples:
  kwatra patterns nuts.png --picture found.png         its elements, as nuts_patterns.json
  kwatra patterns nuts.png --landmarks one.json        all that are like the one in the file

The file is JSON: "format": "kwatra patterns", "version": 1, "width" and "height" of the image, "landmarks":
[[x, y], ...], and "patterns", a list of such lists. Coordinates are pixels, x first. Edit it, and give it back.
"""


def add_patterns(commands: Any) -> None:
    """Add the command to the subparsers of an argument parser."""
    parser = commands.add_parser(
        "patterns",
        help="the patterns that a texture repeats",
        description="Find the patterns that a texture repeats: its elements, or all that are like one given by\n"
        "landmarks. Write them as a file that `kwatra morph` takes.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("image", type=Path, metavar="IMAGE", help="image of the texture")
    add("--landmarks", type=Path, metavar="FILE", help="patterns file with the landmarks of one pattern; its list of "
        "patterns, if it has one, is kept as it is")  # fmt: skip
    add("-o", "--output", type=Path, metavar="OUT", help="the file to write (default: IMAGE_patterns.json, here)")
    add("--picture", type=Path, metavar="FILE", help="draw them over the image, four times as large")
    add("--threshold", type=positive, metavar="T", help="take for the pattern what is up to so far from it (default: "
        "nearer than what is found by chance)")  # fmt: skip
    add("--overwrite", action="store_true", help="replace files that exist")


def run_patterns(arguments: argparse.Namespace) -> str:
    """`kwatra patterns`: returns the summary."""
    from kwatra import InputError
    from synth.io.image_formats import Kind
    from synth.io.images import check_output, image_writer, read_image, write_files
    from synth.morph.patterns import drawn, patterns_of, patterns_writer, read_patterns

    picture = read_image(arguments.image)
    pixels = picture.pixels[:-1] if picture.kind.channels[-1] == "A" else picture.pixels
    output = arguments.output or Path(f"{arguments.image.stem}_patterns.json")
    check_output(output, None, arguments.overwrite, (".json",))
    kind = Kind("uint8", ("R", "G", "B"))
    if arguments.picture is not None:
        check_output(arguments.picture, kind, arguments.overwrite)
    given = None if arguments.landmarks is None else read_patterns(arguments.landmarks)
    if given is None and arguments.threshold is not None:
        raise InputError("--threshold says what is like given landmarks; give --landmarks too, or leave it out")
    image = pixels.permute(1, 2, 0).double().numpy()
    found = patterns_of(image, given, arguments.threshold, str(arguments.image))
    writers = {output: patterns_writer(found.patterns)}
    if arguments.picture is not None:
        writers[arguments.picture] = image_writer(arguments.picture, drawn(pixels, found.patterns), kind)
    write_files(writers)
    return f"wrote {' and '.join(map(str, writers))}: {found.remark}"
