"""The metamorphoses by name: where each lives and what of a pair it looks at. One line here makes a method known."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from kwatra.base import InputError
from synth.metamorphosis.method import Method

PRESETS = ("fast", "default", "best")


@dataclass(frozen=True)
class Entry:
    """A method's module in this package: its PRESETS are a frozen dataclass, a `Method`, by the name of each preset.

    features, tile: whether it looks at the pair's. moves, energies, masks, finds: whether its film has a velocity,
    energies, masks, and features. anywhere: whether it computes on any device; loops and searches of the others run on
    the CPU. least: textures and frames of fewer px along a side are refused: they
    hold no texture to speak of, or no window.
    """

    module: str
    features: bool = False
    tile: bool = False
    moves: bool = False
    energies: bool = False
    masks: bool = False
    finds: bool = False
    anywhere: bool = False
    least: int = 16


METHODS = {
    "control": Entry("optimal_control.control", features=True, tile=True, moves=True, energies=True, anywhere=True),
    "registration": Entry("blend.registration", tile=True, moves=True, energies=True, anywhere=True),
    "blend": Entry("blend.dissolve", tile=True, anywhere=True),
    "patterns": Entry("patterns.method", tile=True, moves=True),
    "patches": Entry("patches.method", features=True, tile=True, finds=True, least=17),
    "textons": Entry("textons.method", masks=True),
}
DEFAULT = "patches"
"""By themselves the best on photographs of bricks, stones and bands; on pebbles and terrazzo patterns are a bit better,
but they refuse what has no distinct elements."""


def entry(name: str) -> Entry:
    """What is known of a method; InputError for a name that is none."""
    if name not in METHODS:
        raise InputError(f"the method is {name!r}; allowed are {', '.join(METHODS)}")
    return METHODS[name]


def method(name: str, preset: str, options: Mapping[str, Any]) -> Method:
    """A method with the settings of a preset, but for those given; InputError for what it does not take."""
    known = entry(name)
    if preset not in PRESETS:
        raise InputError(f"the preset is {preset!r}; allowed are {', '.join(PRESETS)}")
    found: Any = import_module(f"synth.metamorphosis.{known.module}").PRESETS[preset]
    takes = _options(found)
    for option in options:
        if option not in takes:
            allowed = f"it takes {', '.join(takes)}" if takes else "it takes none"
            raise InputError(f"the method {name!r} has no option {option!r}; {allowed}")
    made: Method = _with(found, options)
    return made


def _options(settings: Any) -> list[str]:
    """The names of settings, each once; of settings within settings, their own names."""
    values = {field.name: getattr(settings, field.name) for field in dataclasses.fields(settings)}
    names = (each for name, value in values.items() for each in (_options(value) if _nested(value) else [name]))
    return list(dict.fromkeys(names))


def _with(settings: Any, options: Mapping[str, Any]) -> Any:
    """Settings, and settings within them, with other values of those `_options` that are given."""
    values = {field.name: getattr(settings, field.name) for field in dataclasses.fields(settings)}
    inner = {name: _with(value, options) for name, value in values.items() if _nested(value)}
    own = {name: value for name, value in options.items() if name in values}
    return dataclasses.replace(settings, **inner, **own)


def _nested(value: Any) -> bool:
    return dataclasses.is_dataclass(value)


def refuse_unused(name: str, what: str, asked: bool) -> None:
    """InputError where something is asked that a method has no use for, or does not give; what: a field of `Entry`."""
    if asked and not getattr(entry(name), what):
        those = [other for other, known in METHODS.items() if getattr(known, what)]
        meaning = {
            "features": "takes no features",
            "tile": "cannot tile",
            "moves": "has no flow",
            "energies": "has no energy",
            "masks": "has no masks",
            "finds": "shows no features",
        }[what]
        raise InputError(f"the method {name!r} {meaning}; those that do are {', '.join(those)}")
