"""Videos without alpha: MP4 and GIF. Frames are arrays (H, W, 3) uint8.

MP4 is H.264 in 8 bits, 4:2:0 at high quality, the same bits for the same frames; it has even sides, so an odd one gains
a pixel that repeats the last. A GIF has 256 colors a frame, and shows each for the same time.
"""

from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np


def save_mp4(target: Path, frames: Iterator[np.ndarray], rate: float) -> None:
    """Write frames, one by one, so many a second."""
    import av

    with av.open(str(target), "w", format="mp4") as container:
        stream: Any = None
        for array in frames:
            even = np.pad(array, ((0, len(array) % 2), (0, array.shape[1] % 2), (0, 0)), mode="edge")
            if stream is None:
                stream = container.add_stream("libx264", rate=Fraction(rate).limit_denominator(1001))
                stream.height, stream.width = even.shape[:2]
                _set_up(stream)
            frame = av.VideoFrame.from_ndarray(even, format="rgb24")
            container.mux(stream.encode(frame.reformat(format="yuv420p", dst_colorspace="ITU709")))
        container.mux(stream.encode(None))


def _set_up(stream: Any) -> None:
    """Quality and colors: those of HDTV (BT.709), as players expect and the file says."""
    stream.pix_fmt = "yuv420p"
    # more threads, or the macroblock tree, which reads memory that nothing was written to, change bits between runs
    stream.options = {"crf": "14", "threads": "1", "x264-params": "mbtree=0"}
    context = stream.codec_context
    context.color_range, context.colorspace, context.color_primaries, context.color_trc = 1, 1, 1, 1


def save_gif(target: Path, frames: Iterator[np.ndarray], rate: float) -> None:
    """Write frames, one by one, each for as many hundredths of a second as come nearest to the rate, 2 at least."""
    from PIL import Image
    from PIL.GifImagePlugin import getdata, getheader

    # Frame by frame: Pillow's own writer would drop each frame that equals the last, and hold all of them till the end.
    # Hundredths of a second are all a GIF can say.
    pause = max(round(100 / rate), 2) * 10
    with target.open("wb") as file:
        for array in frames:
            picture = Image.fromarray(array).quantize(256, method=Image.Quantize.MEDIANCUT)
            if file.tell() == 0:
                file.writelines(getheader(picture, info={"loop": 0, "duration": pause})[0])
            file.writelines(getdata(picture, duration=pause, include_color_table=True))
        file.write(b";")
