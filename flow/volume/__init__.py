"""Videos that flow: the flow energy of a whole volume of space and time."""

from flow.volume.term import VolumeFlow

__all__ = ["VolumeFlow"]
