"""Motion: flow fields, warps and their file formats, and textures that flow along them.

Nothing lives here yet. The package stands so that its place is fixed: it may import
``kwatra``, and ``synth`` may import it.
"""

__all__: list[str] = []
