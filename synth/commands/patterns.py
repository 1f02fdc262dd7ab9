"""`kwatra patterns`: the patterns of a texture, found or completed, as a file to edit and a picture to look at."""

import argparse

import synth
from synth import io
from synth.commands.checks import check_distinct, finish
from synth.commands.naming import output_of
from synth.commands.parsing import Subparsers, file, positive
from synth.words import listed

LOADS = ("synth.metamorphosis.patterns", "synth.io.images")

_EPILOG = """examples:
  kwatra patterns nuts.png --picture found.png         its elements, as nuts_patterns.json
  kwatra patterns nuts.png --landmarks one.json        all that are like the one in the file

The file is JSON: "format": "kwatra patterns", "version": 1, "width" and "height" of the image, "landmarks":
[[x, y], ...], and "patterns", a list of such lists. Coordinates are pixels, x first. Edit it, and give it back.
kwatra morph --landmarks takes both textures' from one file: "format": "kwatra landmarks", "version": 1, "a" and "b".
"""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "patterns",
        help="the patterns that a texture repeats",
        description="Find the patterns that a texture repeats: its elements, or all that are like one given by\n"
        "landmarks. Write them as a file that `kwatra morph` takes.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("image", type=file, metavar="IMAGE", help="image of the texture")
    add("--landmarks", type=file, metavar="FILE", help="patterns file with the landmarks of one pattern; its list of "
        "patterns, if it has one, is kept as it is")  # fmt: skip
    add("-o", "--output", type=file, metavar="OUT", help="the file to write, or the folder it goes to (default: "
        "IMAGE_patterns.json in this folder)")  # fmt: skip
    add("--picture", type=file, metavar="FILE", help="draw them over the image, four times as large")
    add("--threshold", type=positive, metavar="T", help="take for the pattern what is up to so far from it (default: "
        "nearer than what is found by chance)")  # fmt: skip
    add("--overwrite", action="store_true", help="replace files that exist")


def run(arguments: argparse.Namespace) -> str:
    """The summary."""
    from synth.metamorphosis.patterns import drawn, patterns_of, patterns_writer, read_patterns

    picture = io.read_image(arguments.image)
    pixels = io.premultiplied(picture.pixels, picture.kind)  # what cannot be seen colors nothing
    pixels = pixels[:-1] if picture.kind.channels[-1] == "A" else pixels
    output = output_of(arguments.output, f"{arguments.image.stem}_patterns.json")
    io.check_output(output, None, arguments.overwrite, (".json",))
    kind = synth.Kind("uint8", ("R", "G", "B"))
    if arguments.picture is not None:
        io.check_output(arguments.picture, kind, arguments.overwrite)
    check_distinct([path for path in (output, arguments.picture) if path is not None])
    given = None if arguments.landmarks is None else read_patterns(arguments.landmarks)
    if given is None and arguments.threshold is not None:
        raise synth.InputError("--threshold says what is like given landmarks; give --landmarks too, or leave it out")
    image = pixels.permute(1, 2, 0).double().numpy()
    found = patterns_of(image, given, arguments.threshold, str(arguments.image), least=0.0)
    writers = {output: patterns_writer(found.patterns)}
    if arguments.picture is not None:
        writers[arguments.picture] = io.image_writer(arguments.picture, drawn(pixels, found.patterns), kind)
    finish(writers, arguments.overwrite)
    return f"wrote {listed(list(writers))}: {found.remark}"
