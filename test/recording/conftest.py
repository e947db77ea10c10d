# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Small recordings, written to a temporary folder."""

from collections.abc import Callable
from pathlib import Path

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.color_frame import ColorFrame
from diffcal_ros.recording.topics.names import COLOR_FRAME, DEPTH_FRAME
from diffcal_ros.rigid_transform import rotation_matrix, transform
from mcap.reader import make_reader
from mcap.writer import Writer
import numpy as np
import pytest

START_NS = 1_628_838_841_927_753_400
PERIOD_NS = 33_333_333


@pytest.fixture
def depth_camera() -> PinholeCamera:
    return PinholeCamera(48, 36, 41.5, 40.25, 22.75, 18.5)


@pytest.fixture
def color_camera() -> PinholeCamera:
    return PinholeCamera(32, 24, 30.0, 29.0, 15.25, 12.5, (-0.1, 0.02, 0.001, 0.0, 0.0))


@pytest.fixture
def depth_from_color() -> np.ndarray:
    return transform(
        rotation_matrix(np.array([0.03, -0.02, 0.05])), np.array([0.014, -0.003, 0.001])
    )


@pytest.fixture
def depth_images(random: np.random.Generator) -> np.ndarray:
    """Twelve depth images with invalid pixels [m], shape (12, 36, 48)."""
    images = random.uniform(0.3, 0.6, (12, 36, 48)).astype(np.float32)
    images[random.random(images.shape) < 0.2] = np.nan
    return images


@pytest.fixture
def color_images(random: np.random.Generator) -> np.ndarray:
    """Twelve colour images, shape (12, 24, 32, 3)."""
    return random.integers(0, 255, (12, 24, 32, 3)).astype(np.uint8)


@pytest.fixture
def write_bag(
    tmp_path: Path, depth_camera, color_camera, depth_from_color, depth_images, color_images
) -> Callable[..., Path]:
    """Write a whole recording; `leave_out` names parts, `extra` writes more."""

    def write(
        *,
        name: str = 'bag',
        encoding: str = '32FC1',
        compression: str = 'zstd',
        leave_out: tuple[str, ...] = (),
        extra: Callable[[BagWriter], None] | None = None,
        frames: np.ndarray = depth_images,
    ) -> Path:
        path = tmp_path / name
        with BagWriter(path, compression=compression) as bag:
            if 'transform' not in leave_out:
                bag.write_depth_from_color(
                    depth_from_color,
                    depth_frame=DEPTH_FRAME,
                    color_frame=COLOR_FRAME,
                    stamp_ns=START_NS,
                )
            for number, image in enumerate(frames):
                stamp = START_NS + number * PERIOD_NS
                if 'depth_camera' not in leave_out:
                    bag.write_depth_camera(depth_camera, stamp_ns=stamp, frame_id=DEPTH_FRAME)
                if 'depth' not in leave_out:
                    bag.write_depth(DepthFrame(image, stamp, DEPTH_FRAME), encoding=encoding)
                if 'color' not in leave_out:
                    bag.write_color_camera(color_camera, stamp_ns=stamp, frame_id=COLOR_FRAME)
                    bag.write_color(ColorFrame(color_images[number], stamp, COLOR_FRAME))
            if extra is not None:
                extra(bag)
        return path

    return write


@pytest.fixture
def rewrite(tmp_path: Path) -> Callable[..., Path]:
    """Write the messages of a bag anew, arranged as asked for (options of mcap's Writer).

    `foreign` is one more message before them: topic, type and bytes.
    """

    def write(
        bag: Path,
        *,
        name: str = 'other.mcap',
        foreign: tuple[str, str, bytes] | None = None,
        **options,
    ) -> Path:
        target = tmp_path / name
        with next(bag.glob('*.mcap')).open('rb') as source, target.open('wb') as stream:
            writer = Writer(stream, **options)
            writer.start('ros2')
            channels = {}
            if foreign is not None:
                topic, type_name, content = foreign
                number = writer.register_schema(type_name, 'ros2msg', b'')
                channels[topic] = writer.register_channel(topic, 'cdr', number)
                writer.add_message(channels[topic], START_NS, content, START_NS)
            for schema, channel, record in make_reader(source).iter_messages():
                if channel.topic not in channels:
                    number = writer.register_schema(schema.name, schema.encoding, schema.data)
                    channels[channel.topic] = writer.register_channel(channel.topic, 'cdr', number)
                writer.add_message(
                    channels[channel.topic], record.log_time, record.data, record.publish_time
                )
            writer.finish()
        return target

    return write
