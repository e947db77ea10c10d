# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Predicted depth as NumPy files, or as a bag that everything else here reads."""

from pathlib import Path

from diffcal_ros.atomic_file import replacing, write_json_atomically
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.prediction.predicted_view import PredictedView
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.names import DEPTH_FRAME
import numpy as np

_FIRST_STAMP_NS = 1_700_000_000_000_000_000
_SECOND = 1_000_000_000  # [ns]


def write_depth_files(view: PredictedView, folder: Path) -> None:
    """Write each frame as .npz with `depth` [m] and `time` [s], and the camera beside them.

    Raises:
        InputError: when the folder cannot be written.
    """
    camera, times = view.camera, view.body.times.tolist()
    for number, (time, depth) in enumerate(zip(times, view.depths(), strict=True)):
        with replacing(folder / f'{number:04d}.npz') as fresh:
            np.savez_compressed(fresh, depth=depth, time=time)
    about = {
        'width': camera.width,
        'height': camera.height,
        'K': camera.K.tolist(),
        'depth_from_world': view.depth_from_world.tolist(),
        'times': times,
    }
    write_json_atomically(folder / 'camera.json', about)


def write_depth_bag(view: PredictedView, path: Path, *, overwrite: bool) -> None:
    """Write depth as 32FC1 with its camera_info.

    Raises:
        RecordingError: when something is there already, or the disk is full.
    """
    with BagWriter(path, overwrite=overwrite) as bag:
        for time, depth in zip(view.body.times.tolist(), view.depths(), strict=True):
            stamp = _FIRST_STAMP_NS + round(_SECOND * time)
            bag.write_depth_camera(view.camera, stamp_ns=stamp, frame_id=DEPTH_FRAME)
            bag.write_depth(DepthFrame(depth, stamp, DEPTH_FRAME))
