# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Sound files whose messages are not: what a driver, a converter or a script may have written."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from diffcal_ros.errors import InputError
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.topics.ros_messages import deserialize, serialize
import numpy as np

from benchmarks.faults.layouts import Layout, Recorded, write_layout
from benchmarks.faults.oracle import COLOR, DEPTH, HangError, pixels_of, time_limit
from benchmarks.faults.outcome import Outcome

_LAYOUT = Layout('this package', has_data_checksum=True)
_LONGEST = 1500
_ODD_TEXTS = ('', 'bgr8', 'mono8', '16UC1', '32FC1', '64FC1', 'yuv422', 'x' * 5000, 'é\x1b[31m')
_ODD_SIZES = (0, 1, 7, 2**16, 2**31, 2**32 - 1)
Change = Callable[[Recorded, np.random.Generator], bytes]


def flip(message: Recorded, random: np.random.Generator) -> bytes:
    """Change a few bytes anywhere."""
    content = bytearray(message.data)
    for place in random.integers(0, len(content), size=int(random.integers(1, 4))):
        content[place] ^= 1 << int(random.integers(8))
    return bytes(content)


def flip_head(message: Recorded, random: np.random.Generator) -> bytes:
    """Change a byte where a message says what and how large it is."""
    content = bytearray(message.data)
    content[int(random.integers(min(96, len(content))))] ^= 1 << int(random.integers(8))
    return bytes(content)


def cut(message: Recorded, random: np.random.Generator) -> bytes:
    """Keep the beginning alone, or nothing."""
    return message.data[: int(random.integers(0, len(message.data)))]


def grow(message: Recorded, random: np.random.Generator) -> bytes:
    """Append what does not belong there."""
    return message.data + random.bytes(int(random.integers(1, 300)))


def noise(message: Recorded, random: np.random.Generator) -> bytes:
    """Replace everything."""
    return random.bytes(int(random.integers(0, 400)))


def odd_image(message: Recorded, random: np.random.Generator) -> bytes:
    """Let an image say another encoding, size or byte order."""
    if message.topic not in (DEPTH, COLOR):
        return flip(message, random)
    image = deserialize(message.data, message.type_name)
    field = str(random.choice(['encoding', 'width', 'height', 'step', 'is_bigendian', 'frame_id']))
    if field == 'encoding':
        image.encoding = str(random.choice(_ODD_TEXTS))
    elif field == 'frame_id':
        image.header.frame_id = str(random.choice(_ODD_TEXTS))
    elif field == 'is_bigendian':
        image.is_bigendian = 1
    else:
        setattr(image, field, int(random.choice(_ODD_SIZES)))
    return serialize(image)


def odd_pixels(message: Recorded, random: np.random.Generator) -> bytes:
    """Let an image hold nothing, or what no camera measures."""
    if message.topic != DEPTH:
        return flip(message, random)
    image = deserialize(message.data, message.type_name)
    pixels = np.full(
        image.data.size // 4, float(random.choice([0.0, np.nan, np.inf, -1.0, 1e30])), '<f4'
    )
    image.data = pixels.view(np.uint8)
    return serialize(image)


def odd_stamp(message: Recorded, random: np.random.Generator) -> bytes:
    """Let a message be of another time."""
    stamp = random.choice(np.array([0, 1, 2**31 - 1, 2**32 - 1], np.uint32), size=2)
    return message.data[:4] + stamp.astype('<u4').tobytes() + message.data[12:]


CHANGES: tuple[Change, ...] = (
    *(flip, flip_head, cut, grow, noise),
    *(odd_image, odd_pixels, odd_stamp),
)


def content_cases(
    messages: list[Recorded], folder: Path, count: int, seed: int
) -> Iterator[Outcome]:
    """Change a message or two of a recording, `count` times; yield what came of each."""
    for number in range(count):
        random = np.random.default_rng((seed, number))
        change = CHANGES[number % len(CHANGES)]
        places = random.choice(len(messages), size=int(random.integers(1, 3)), replace=False)
        changed = list(messages)
        for place in places:
            changed[place] = replace(
                messages[place], data=change(messages[place], random) or b'\x00'
            )
        file = folder / 'content.mcap'
        file.write_bytes(write_layout(_LAYOUT, changed).content)
        topics = [messages[place].topic for place in sorted(places)]
        name = f'{change.__name__} {(seed, number)} of {", ".join(topics)}'
        untouched = [one for place, one in enumerate(messages) if place not in set(places)]
        yield Outcome('content', name, *_judge(file, messages, untouched))


def _judge(file: Path, messages: list[Recorded], untouched: list[Recorded]) -> tuple[str, str]:
    try:
        with time_limit():
            recording = open_recording(file)
            found = {
                DEPTH: Counter(frame.depth.tobytes() for frame in recording.depth_frames()),
                COLOR: Counter(frame.image.tobytes() for frame in recording.color_frames()),
            }
            skipped = recording.skipped
            told = ' '.join(recording.notes)
    except InputError as error:
        return ('refused' if len(str(error)) < _LONGEST else 'traceback'), str(error)[:300]
    except HangError:
        return 'hang', ''
    except Exception as error:
        return 'traceback', repr(error)
    for topic, images in found.items():
        sent = sum(one.topic == topic for one in messages)
        left_out = sum(n for reason, n in skipped.items() if reason.startswith(topic))
        if recording.color_topic is None and topic == COLOR:
            return 'read in part', told or 'no colour topic'
        if images.total() + left_out != sent:
            return 'silent loss', f'{topic}: {sent} sent, {images.total()} read, {left_out} told'
        lost = Counter(pixels_of(one) for one in untouched if one.topic == topic) - images
        if lost.total() > left_out:
            return 'silent loss', f'{topic}: {lost.total()} good images did not come as they are'
    return ('read in part' if skipped else 'read whole'), ''
