# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fit as a recording for Rerun's viewer."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import replacing
from diffcal_ros.errors import InputError
from diffcal_ros.report.palette import FITTED
from diffcal_ros.report.scene_picture.scene_legend import HELD_COLOR
from diffcal_ros.web.fitted_view import SeenBody
from diffcal_ros.web.stage import rgb
import numpy as np

_POINT = 0.0004  # Radius [m].


def write_rerun(path: Path, bodies: Sequence[SeenBody], words: str) -> None:
    """Write every observation as a branch of its own, all in the world frame.

    Args:
        path: the file, usually `.rrd`.
        bodies: what is drawn.
        words: figures of the fit, Markdown.

    Raises:
        InputError: when rerun-sdk is missing, or the file cannot be written.
    """
    rerun = require_rerun()
    with replacing(path) as fresh:
        stream = rerun.RecordingStream('diffcal')
        stream.save(str(fresh))
        figures = rerun.TextDocument(words, media_type=rerun.MediaType.MARKDOWN)
        stream.log('figures', figures, static=True)
        for number, body in enumerate(bodies):
            _log(rerun, stream, f'observation_{number}', body)
        stream.flush()
        stream.disconnect()


def require_rerun() -> Any:
    """Return Rerun's package.

    Raises:
        InputError: when it is missing.
    """
    try:
        import rerun
    except ImportError as error:
        raise InputError(
            'a recording for Rerun needs rerun-sdk: python -m pip install '
            "'diffcal_ros[rerun]', or rerun-sdk"
        ) from error
    return rerun


def _log(rerun: Any, stream: Any, name: str, body: SeenBody) -> None:
    colors = body.by_distance if body.by_camera is None else body.by_camera
    for part, triangles, color in (
        ('body', body.triangles, FITTED),
        ('held', body.held_triangles, HELD_COLOR),
    ):
        used, own = np.unique(triangles, return_inverse=True)
        surface = rerun.Mesh3D(
            vertex_positions=body.vertices[used],
            triangle_indices=own.reshape(-1, 3),
            vertex_colors=np.tile(rgb(color), (len(used), 1)),
        )
        stream.log(f'{name}/{part}', surface, static=True)
    points = rerun.Points3D(body.points, colors=colors, radii=_POINT)
    stream.log(f'{name}/points', points, static=True)
    camera = body.camera
    stream.log(
        f'{name}/camera',
        rerun.Transform3D(
            translation=body.world_from_depth[:3, 3], mat3x3=body.world_from_depth[:3, :3]
        ),
        rerun.Pinhole(
            image_from_camera=camera.K,
            width=camera.width,
            height=camera.height,
            image_plane_distance=0.03,
        ),
        static=True,
    )
