# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A film of depth images in one scale, as animated GIF or MP4, or a PNG of a single image."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import write_bytes_atomically
from diffcal_ros.report import palette
from diffcal_ros.report.figures.figure_png import new_figure, png_bytes
import numpy as np
from numpy.typing import NDArray

DepthArray = NDArray[np.float32]
Picture = NDArray[np.uint8]
# Gives the images anew each time it is called: a film is not kept in memory.
Depths = Callable[[], Iterable[DepthArray]]

FILM_FORMATS = ('gif', 'mp4')

_WIDTH = 6.4  # [inch]
_HEIGHTS = (2.4, 6.0)
_BAR_WIDTH = 1.2
_MARGIN = 0.05  # Around the body, over its larger side.
_DEPTH_MARGIN = 0.003  # Of the colour scale beyond the body's depths [m].
# Many viewers take shorter pauses for a mistake and wait a tenth of a second instead [s].
_SHORTEST_PAUSE = 0.02
# Pauses that differ by less than this share are even: rounding of times.
_EVEN = 1e-6


@dataclass(frozen=True)
class FilmFrame:
    """What all images of a film are drawn in.

    Attributes:
        rows: of the window.
        columns: of the window.
        limits: ends of the scale of depths [mm].
    """

    rows: slice
    columns: slice
    limits: tuple[float, float]


def film_frame(depths: Iterable[DepthArray]) -> FilmFrame:
    """Return the window and the scale that hold the body in every image [m], NaN beside it.

    Raises:
        ValueError: when no image shows anything.
    """
    rows: list[int] = []
    columns: list[int] = []
    ends: list[float] = []
    shape = (0, 0)
    for depth in depths:
        shape = (depth.shape[0], depth.shape[1])
        seen = np.isfinite(depth)
        if seen.any():
            rows += np.flatnonzero(seen.any(axis=1))[[0, -1]].tolist()
            columns += np.flatnonzero(seen.any(axis=0))[[0, -1]].tolist()
            ends += [float(depth[seen].min()), float(depth[seen].max())]
    if not ends:
        raise ValueError('no image of the film shows anything')
    margin = 2 + int(_MARGIN * max(np.ptp(rows), np.ptp(columns)))
    return FilmFrame(
        rows=slice(max(min(rows) - margin, 0), min(max(rows) + margin + 1, shape[0])),
        columns=slice(max(min(columns) - margin, 0), min(max(columns) + margin + 1, shape[1])),
        limits=(1e3 * (min(ends) - _DEPTH_MARGIN), 1e3 * (max(ends) + _DEPTH_MARGIN)),
    )


def write_film(
    path: Path, depths: Depths, times: Sequence[float], *, title: str, slowdown: float
) -> None:
    """Write images as an animated GIF that repeats, or as MP4: the path's suffix says which.

    Args:
        path: file that ends in one of `FILM_FORMATS`.
        depths: gives the images [m], shape (H, W), NaN where nothing is.
        times: of them [s], at least two; evenly spaced for MP4.
        title: above them.
        slowdown: how many times slower than in truth it plays.

    Raises:
        InputError: when the file cannot be written.
        ValueError: for an unknown suffix, or for MP4 of images at uneven times.
    """
    film_format = path.suffix.removeprefix('.')
    if film_format not in FILM_FORMATS:
        raise ValueError(f'{path.name} is no film: end it in one of {", ".join(FILM_FORMATS)}')
    drawing = _Drawing(film_frame(depths()), title, slowdown)
    pictures = (drawing.draw(depth, time) for depth, time in zip(depths(), times, strict=True))
    pauses = slowdown * np.diff(times, append=2 * times[-1] - times[-2])
    if film_format == 'gif':
        _write_gif(path, pictures, pauses)
        return
    from diffcal_ros.recording.mp4_file import write_mp4

    if np.ptp(pauses) > _EVEN * pauses.mean():
        raise ValueError('the images are at uneven times and MP4 has one rate: write a GIF')
    write_mp4(path, pictures, 1.0 / pauses.mean())


def _write_gif(path: Path, pictures: Iterable[Picture], pauses: NDArray[np.float64]) -> None:
    from PIL import Image

    images = (Image.fromarray(p).quantize(dither=Image.Dither.NONE) for p in pictures)
    first = next(images)
    content = BytesIO()
    first.save(
        content,
        format='GIF',
        save_all=True,
        append_images=images,
        duration=np.rint(1e3 * np.maximum(pauses, _SHORTEST_PAUSE)).astype(int).tolist(),
        loop=0,
    )
    write_bytes_atomically(path, content.getvalue())


def write_still(path: Path, depth: DepthArray, *, title: str) -> None:
    """Write one image as PNG.

    Raises:
        InputError: when the file cannot be written.
    """
    drawing = _Drawing(film_frame([depth]), title, 1.0)
    drawing.draw(depth, None)
    write_bytes_atomically(path, png_bytes(drawing.figure))


class _Drawing:
    """One figure in which the images take turns."""

    def __init__(self, frame: FilmFrame, title: str, slowdown: float) -> None:
        self._frame, self._title = frame, title
        self._speed = '' if slowdown == 1.0 else f', {slowdown:g} times slowed down'
        rows, columns = frame.rows, frame.columns
        aspect = (rows.stop - rows.start) / (columns.stop - columns.start)
        height = float(np.clip((_WIDTH - _BAR_WIDTH) * aspect, *_HEIGHTS))
        self.figure = new_figure(_WIDTH, height + 0.5)
        self._axes = self.figure.subplots()
        self._axes.set_xticks([])
        self._axes.set_yticks([])
        self._image: Any = None

    def draw(self, depth: DepthArray, time: float | None) -> Picture:
        """Draw an image [m]; return the picture, shape (h, w, 3)."""
        window = 1e3 * depth[self._frame.rows, self._frame.columns]
        if self._image is None:
            low, high = self._frame.limits
            self._image = self._axes.imshow(
                window, cmap=palette.depth_map(), vmin=low, vmax=high, interpolation='nearest'
            )
            bar = self.figure.colorbar(self._image, ax=self._axes, pad=0.02)
            bar.set_label('depth [mm]')
        self._image.set_data(window)
        when = '' if time is None else f', {time:.3f} s{self._speed}'
        self._axes.set_title(f'{self._title}{when}', fontsize=11)
        self.figure.canvas.draw()
        # Laid out once: a picture that moves by a pixel looks like a body that does.
        self.figure.set_layout_engine('none')
        picture: Picture = np.asarray(self.figure.canvas.buffer_rgba())[..., :3].copy()
        return picture
