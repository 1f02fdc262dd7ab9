"""Videos that keep alpha: WebM (VP9, for the web) and MOV (ProRes 4444, for editing), where PyAV has the encoders.

Both hold colors of BT.709 and come out as the same bits for the same frames. ProRes keeps colors at full resolution
and 10 bits; VP9 halves the resolution of colors, as MP4 does. Frames are arrays (H, W, 3 or 4) uint8, straight alpha.
"""

from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from kwatra.base import InputError

_CODECS = {".webm": "libvpx-vp9", ".mov": "prores_ks"}
_FORMATS = {".webm": ("yuv420p", "yuva420p"), ".mov": ("yuv444p10le", "yuva444p10le")}
_OPTIONS = {
    ".webm": {"crf": "10", "b:v": "0", "threads": "1", "row-mt": "0", "deadline": "good", "cpu-used": "2"},
    ".mov": {"profile": "4", "vendor": "apl0", "alpha_bits": "8", "threads": "1"},
}
ALPHA_SUFFIXES = tuple(_CODECS)


def check_encoder(path: Path) -> None:
    """Refuse a file for which there is no encoder here."""
    import av

    codec = _CODECS[path.suffix.lower()]
    try:
        av.codec.Codec(codec, "w")
    except ValueError as error:
        raise InputError(
            f"{path} needs the encoder {codec}, which this PyAV lacks; use .mp4 or a folder of frames"
        ) from error


def save_with_alpha(target: Path, frames: Iterator[np.ndarray], rate: float) -> None:
    """Write frames (H, W, 3 or 4), one by one, in the format that the ending names."""
    import av

    suffix = target.suffix.lower()
    container_format = "webm" if suffix == ".webm" else "mov"
    with av.open(str(target), "w", format=container_format, options={"fflags": "+bitexact"}) as container:
        stream: Any = None
        for array in frames:
            form = _FORMATS[suffix][array.shape[2] == 4]
            if stream is None:
                stream = container.add_stream(_CODECS[suffix], rate=Fraction(rate).limit_denominator(1001))
                stream.height, stream.width, stream.pix_fmt = *array.shape[:2], form
                stream.options = _OPTIONS[suffix]
                if suffix == ".webm" and array.shape[2] == 4:
                    stream.metadata["alpha_mode"] = "1"
                context = stream.codec_context
                context.color_range, context.colorspace, context.color_primaries, context.color_trc = 1, 1, 1, 1
                context.flags |= av.codec.context.Flags.bitexact
            frame = av.VideoFrame.from_ndarray(
                np.ascontiguousarray(array), format=("rgb24", "rgba")[array.shape[2] == 4]
            )
            container.mux(stream.encode(frame.reformat(format=form, dst_colorspace="ITU709")))
        container.mux(stream.encode(None))


def has_alpha(stream: Any) -> bool:
    """Whether a video stream says that it holds alpha."""
    tags = {name.lower(): value for name, value in stream.metadata.items()}
    return tags.get("alpha_mode") == "1" or "yuva" in str(stream.codec_context.pix_fmt)


def frames_with_alpha(container: Any, stream: Any) -> Iterable[Any]:
    """The frames of a stream with alpha; the usual decoder of VP9 leaves it out."""
    import av

    if stream.codec_context.name != "vp9":
        yield from container.decode(stream)
        return
    decoder = av.CodecContext.create("libvpx-vp9", "r")
    for packet in container.demux(stream):
        yield from decoder.decode(packet)
