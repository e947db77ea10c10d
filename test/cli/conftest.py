# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Commands run in this process, and copies of a small recording with something wrong in them."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
import shutil
from typing import Any

from diffcal_ros.cli.main import main
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.names import COLOR_FRAME, DEPTH_FRAME
import numpy as np
import pytest
import yaml


@dataclass(frozen=True)
class Ran:
    """A command that has ended."""

    code: int
    out: str
    err: str


@pytest.fixture
def run_cli(capsys) -> Callable[..., Ran]:
    """Run `diffcal` with some arguments."""

    def run(*arguments: Any) -> Ran:
        capsys.readouterr()
        code = main([str(argument) for argument in arguments])
        return Ran(code, *capsys.readouterr())

    return run


@pytest.fixture
def change_scene(recorded_beam, tmp_path) -> Callable[..., Path]:
    """Copy the recorded beam's scene with dotted keys changed; `...` removes a key."""

    def change(
        changes: dict[str, Any] | None = None, mesh: Callable[[str], str] | None = None
    ) -> Path:
        source = recorded_beam.scene
        document = yaml.safe_load(source.read_text())
        document['bag'] = str(recorded_beam.bags['observation'])
        for dotted, value in (changes or {}).items():
            *sections, key = dotted.split('.')
            section = document
            for name in sections:
                section = section.setdefault(name, {})
            if value is ...:
                del section[key]
            else:
                section[key] = value
        folder = tmp_path / 'changed'
        folder.mkdir()
        shutil.copy(source.parent / 'beam.tet', folder)
        if mesh is not None:
            (folder / 'beam.tet').write_text(mesh((folder / 'beam.tet').read_text()))
        (folder / 'scene.yaml').write_text(yaml.safe_dump(document))
        return folder / 'scene.yaml'

    return change


@pytest.fixture
def change_bag(recorded_beam, tmp_path) -> Callable[..., Path]:
    """Copy the beam's recording, spoilt.

    `leave_out` names depth, depth_camera, color or transform; `depth` and `color` change each
    image; `extra` writes more.
    """

    def change(
        *,
        leave_out: tuple[str, ...] = (),
        depth: Callable[[np.ndarray], np.ndarray] = lambda image: image,
        color: Callable[[np.ndarray], np.ndarray] = lambda image: image,
        extra: Callable[[BagWriter, int], None] | None = None,
    ) -> Path:
        source = open_recording(recorded_beam.bags['observation'])
        path = tmp_path / 'spoilt'
        with BagWriter(path) as bag:
            stamp = source.first_stamp_ns
            if 'transform' not in leave_out:
                bag.write_depth_from_color(
                    source.depth_from_color,
                    depth_frame=DEPTH_FRAME,
                    color_frame=COLOR_FRAME,
                    stamp_ns=stamp,
                )
            for frame in source.depth_frames():
                stamp = frame.stamp_ns
                if 'depth_camera' not in leave_out:
                    bag.write_depth_camera(
                        source.depth_camera, stamp_ns=stamp, frame_id=DEPTH_FRAME
                    )
                if 'depth' not in leave_out:
                    bag.write_depth(DepthFrame(depth(frame.depth.copy()), stamp, DEPTH_FRAME))
            for frame in source.color_frames() if 'color' not in leave_out else ():
                bag.write_color_camera(
                    source.color_camera, stamp_ns=frame.stamp_ns, frame_id=COLOR_FRAME
                )
                bag.write_color(type(frame)(color(frame.image), frame.stamp_ns, COLOR_FRAME))
            if extra is not None:
                extra(bag, stamp)
        return path

    return change
