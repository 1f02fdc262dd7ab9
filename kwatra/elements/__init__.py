"""The elements of a texture: how large they are, what is between them, the lattice or rows they stand on, and lines."""

from kwatra.elements.anisotropy import STRAIGHT, anisotropy, drawn_sides, easier, runs_along
from kwatra.elements.direction import direction_dependence
from kwatra.elements.frame import grown
from kwatra.elements.ground import find_ground
from kwatra.elements.lattice import Lattice, find_lattice
from kwatra.elements.outlines import Outlines, find_outlines
from kwatra.elements.place import place_dependence
from kwatra.elements.repeating import LOOKED_AT, continued, find_repeats, out_of_step
from kwatra.elements.rows import Rows, find_rows
from kwatra.elements.size import element_size
from kwatra.elements.slant import Slant, find_slant
from kwatra.elements.splits import Ground, middle_of
from kwatra.elements.translation import translation
from kwatra.elements.woven import continued_weave, find_weave, lines_through, weave_beside

__all__ = [
    "LOOKED_AT",
    "STRAIGHT",
    "Ground",
    "Lattice",
    "Outlines",
    "Rows",
    "Slant",
    "anisotropy",
    "continued",
    "continued_weave",
    "direction_dependence",
    "drawn_sides",
    "easier",
    "element_size",
    "find_ground",
    "find_lattice",
    "find_outlines",
    "find_repeats",
    "find_rows",
    "find_slant",
    "find_weave",
    "grown",
    "lines_through",
    "middle_of",
    "out_of_step",
    "place_dependence",
    "runs_along",
    "translation",
    "weave_beside",
]
