"""Files, whole or not at all: images, videos, flows, folders of frames."""

from typing import TYPE_CHECKING

from synth.lazy import lazy

if TYPE_CHECKING:
    from synth.io.alpha import mixed, premultiplied, straight, unmixed
    from synth.io.flows import FLOW_SUFFIXES, check_flow_output, field_of, flow_writer, read_flow
    from synth.io.frames import FramesFolder
    from synth.io.images import (
        Picture,
        array_writer,
        check_output,
        image_writer,
        read_array,
        read_image,
        read_mask,
        read_values,
        to_pixels,
    )
    from synth.io.kinds import Array, Kind
    from synth.io.numpy_files import npy_writer
    from synth.io.outputs import Writer, bytes_writer, check_writable, staged, write_files
    from synth.io.raising import raised
    from synth.io.reels import Reel
    from synth.io.videos import (
        VIDEO_SUFFIXES,
        Clip,
        check_video_output,
        extremes_of,
        is_video,
        read_video,
        video_writer,
        written_like,
    )

__all__ = [
    "FLOW_SUFFIXES",
    "VIDEO_SUFFIXES",
    "Array",
    "Clip",
    "FramesFolder",
    "Kind",
    "Picture",
    "Reel",
    "Writer",
    "array_writer",
    "as_kind",
    "bytes_writer",
    "check_flow_output",
    "check_output",
    "check_video_output",
    "check_writable",
    "extremes_of",
    "field_of",
    "flow_writer",
    "image_writer",
    "is_video",
    "mixed",
    "npy_writer",
    "premultiplied",
    "raised",
    "read_array",
    "read_flow",
    "read_image",
    "read_mask",
    "read_values",
    "read_video",
    "reading",
    "richest",
    "staged",
    "straight",
    "to_pixels",
    "unmixed",
    "video_writer",
    "write_files",
    "written_like",
]

__getattr__, __dir__ = lazy(
    __name__,
    {
        "FLOW_SUFFIXES": "synth.io.flows",
        "VIDEO_SUFFIXES": "synth.io.videos",
        "Array": "synth.io.kinds",
        "Clip": "synth.io.videos",
        "FramesFolder": "synth.io.frames",
        "Kind": "synth.io.kinds",
        "Picture": "synth.io.images",
        "Reel": "synth.io.reels",
        "Writer": "synth.io.outputs",
        "array_writer": "synth.io.images",
        "as_kind": "synth.io.raising",
        "bytes_writer": "synth.io.outputs",
        "check_flow_output": "synth.io.flows",
        "check_output": "synth.io.images",
        "check_video_output": "synth.io.videos",
        "check_writable": "synth.io.outputs",
        "extremes_of": "synth.io.videos",
        "field_of": "synth.io.flows",
        "flow_writer": "synth.io.flows",
        "image_writer": "synth.io.images",
        "is_video": "synth.io.videos",
        "mixed": "synth.io.alpha",
        "npy_writer": "synth.io.numpy_files",
        "premultiplied": "synth.io.alpha",
        "raised": "synth.io.raising",
        "read_array": "synth.io.images",
        "read_flow": "synth.io.flows",
        "read_image": "synth.io.images",
        "read_mask": "synth.io.images",
        "read_values": "synth.io.images",
        "read_video": "synth.io.videos",
        "reading": "synth.io.unreadable",
        "richest": "synth.io.raising",
        "staged": "synth.io.outputs",
        "straight": "synth.io.alpha",
        "to_pixels": "synth.io.images",
        "unmixed": "synth.io.alpha",
        "video_writer": "synth.io.videos",
        "write_files": "synth.io.outputs",
        "written_like": "synth.io.videos",
    },
)
