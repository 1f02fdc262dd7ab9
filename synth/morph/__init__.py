"""Metamorphosis: frames that lead from one texture to another, each of them a texture (one folder per method).

The package is callable: `synth.morph(a, b, method=...)` is `synth.morph.door.morph`.
"""

import sys
from types import ModuleType
from typing import Any


class _Door(ModuleType):
    """A package that is called like the function it is named for: importing any of its modules would hide that one."""

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        from synth.morph.door import morph

        return morph(*arguments, **named)


sys.modules[__name__].__class__ = _Door
