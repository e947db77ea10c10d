# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Write the same messages as mcap files of every layout, and note where each message stands."""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
import zlib

from diffcal_ros.recording.topics.ros_messages import deserialize, serialize
import lz4.frame
from mcap.data_stream import RecordBuilder
from mcap.reader import make_reader
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Message,
    MessageIndex,
    Schema,
    Statistics,
)
import numpy as np
import zstandard

MAGIC = b'\x89MCAP0\r\n'
_PACK = {'': bytes, 'zstd': zstandard.compress, 'lz4': lz4.frame.compress}


@dataclass(frozen=True)
class Layout:
    """How a recorder arranges a file.

    Attributes:
        name: for the table.
        compression: of chunks; None: there are no chunks.
        has_chunk_checksums: likewise.
        has_data_checksum: over all of the data.
        has_summary_checksum: likewise.
        has_index: whether chunks are followed by message indexes and the summary lists them.
        has_summary: whether statistics and channels stand behind the data.
        has_end: False for a recorder that was killed.
        is_split: whether this is the second file of a bag, with a metadata.yaml.
    """

    name: str
    compression: str | None = 'zstd'
    has_chunk_checksums: bool = True
    has_data_checksum: bool = False
    has_summary_checksum: bool = True
    has_index: bool = True
    has_summary: bool = True
    has_end: bool = True
    is_split: bool = False


LAYOUTS = (
    Layout('this package', has_data_checksum=True),
    Layout('rosbag2', compression=''),
    Layout('rosbag2 zstd_fast', has_chunk_checksums=False, has_summary_checksum=False),
    Layout('lz4 without checksums', 'lz4', False, False, False),
    Layout('rosbag2 fastwrite', None, False, False, False, False),
    Layout('no chunks, checksum over all', None, False, True, True, False),
    Layout('no index', compression='', has_index=False),
    Layout('no summary', compression='', has_summary=False),
    Layout('recorder killed', compression='', has_end=False),
    Layout('neither chunks nor summary', None, False, False, False, False, False),
    Layout('split bag', compression='', is_split=True),
    Layout('split bag, fastwrite', None, False, False, False, False, is_split=True),
)


@dataclass(frozen=True)
class Recorded:
    """A message as it was recorded."""

    topic: str
    type_name: str
    definition: bytes
    time_ns: int
    data: bytes


@dataclass(frozen=True)
class Place:
    """A record of the file and the numbers of the messages that it holds."""

    kind: str
    start: int
    end: int
    messages: tuple[int, ...] = ()


@dataclass
class Written:
    """A file and where everything stands in it."""

    layout: Layout
    messages: list[Recorded]
    content: bytes = b''
    places: list[Place] = field(default_factory=list)


def sample_messages(path: Path, frames: int = 8, every: int = 8) -> list[Recorded]:
    """Take the messages of a bag up to so many depth images, by the library's own reader.

    Of images one row and column in as many is taken.
    """
    taken: list[Recorded] = []
    depth = 0
    with path.open('rb') as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            depth += channel.topic.startswith('/depth/image')
            if depth > frames:
                break
            data = _smaller(message.data, schema.name, every)
            taken.append(Recorded(channel.topic, schema.name, schema.data, message.log_time, data))
    return taken


def _smaller(data: bytes, type_name: str, every: int) -> bytes:
    if type_name not in ('sensor_msgs/msg/Image', 'sensor_msgs/msg/CameraInfo'):
        return data
    message = deserialize(data, type_name)
    if type_name == 'sensor_msgs/msg/Image':
        rows = message.data.reshape(message.height, message.width, -1)[::every, ::every]
        message.data = np.ascontiguousarray(rows).reshape(-1)
        message.step = rows.shape[1] * rows.shape[2]
    message.height = -(-message.height // every)
    message.width = -(-message.width // every)
    return serialize(message)


def write_layout(layout: Layout, messages: list[Recorded], chunk_size: int = 120_000) -> Written:
    """Arrange messages in a file."""
    return _Arranger(layout, messages, chunk_size).written


class _Arranger:
    def __init__(self, layout: Layout, messages: list[Recorded], chunk_size: int) -> None:
        self.written = Written(layout, messages)
        self._out = bytearray(MAGIC)
        self._numbers: dict[str, int] = {}
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._put('header', Header('ros2', 'a recorder'))
        pending: list[int] = []
        for number, message in enumerate(messages):
            if layout.compression is None:
                self._describe(message)
                self._put('message', self._message(number), (number,))
                continue
            pending.append(number)
            if sum(len(messages[one].data) for one in pending) > chunk_size:
                self._add_chunk(pending)
                pending = []
        if pending:
            self._add_chunk(pending)
        if layout.has_end:
            self._finish()
        self.written.content = bytes(self._out)

    def _put(self, kind: str, record, messages: tuple[int, ...] = ()) -> None:
        start = len(self._out)
        self._out += _bytes(record)
        self.written.places.append(Place(kind, start, len(self._out), messages))

    def _describe(self, message: Recorded, into: bytearray | None = None) -> None:
        """Write schema and channel where a topic comes for the first time."""
        if message.topic in self._numbers:
            return
        number = self._numbers[message.topic] = len(self._numbers) + 1
        self._schemas.append(
            Schema(id=number, name=message.type_name, encoding='ros2msg', data=message.definition)
        )
        self._channels.append(Channel(number, message.topic, 'cdr', {}, number))
        for record in (self._schemas[-1], self._channels[-1]):
            if into is None:
                self._put('description', record)
            else:
                into += _bytes(record)

    def _message(self, number: int) -> Message:
        message = self.written.messages[number]
        return Message(
            self._numbers[message.topic], message.time_ns, message.data, message.time_ns, number
        )

    def _add_chunk(self, numbers: list[int]) -> None:
        layout, messages = self.written.layout, self.written.messages
        content, offsets = bytearray(), {}
        for number in numbers:
            self._describe(messages[number], content)
            offsets.setdefault(self._numbers[messages[number].topic], []).append(
                (messages[number].time_ns, len(content))
            )
            content += _bytes(self._message(number))
        times = [messages[number].time_ns for number in numbers]
        packed = _PACK[layout.compression](bytes(content))
        checksum = zlib.crc32(content) if layout.has_chunk_checksums else 0
        start = len(self._out)
        self._put(
            'chunk',
            Chunk(layout.compression, packed, max(times), min(times), checksum, len(content)),
            tuple(numbers),
        )
        end = len(self._out)
        indexes = {}
        if layout.has_index:
            for channel, listed in offsets.items():
                indexes[channel] = len(self._out)
                self._put('index', MessageIndex(channel, listed))
        self._chunks.append(
            ChunkIndex(
                chunk_length=end - start,
                chunk_start_offset=start,
                compression=layout.compression,
                compressed_size=len(packed),
                message_end_time=max(times),
                message_index_length=len(self._out) - end,
                message_index_offsets=indexes,
                message_start_time=min(times),
                uncompressed_size=len(content),
            )
        )

    def _finish(self) -> None:
        layout = self.written.layout
        checksum = zlib.crc32(self._out) if layout.has_data_checksum else 0
        self._put('data end', DataEnd(checksum))
        start = len(self._out) if layout.has_summary else 0
        if layout.has_summary:
            for record in (*self._schemas, *self._channels, self._statistics()):
                self._put('summary', record)
            for index in self._chunks if layout.has_index else ():
                self._put('summary', index)
        footer = _bytes(Footer(start, 0, 0))
        if layout.has_summary_checksum:
            covered = self._out[start or len(self._out) :] + footer[:-4]
            footer = footer[:-4] + zlib.crc32(covered).to_bytes(4, 'little')
        self._out += footer + MAGIC
        self.written.places.append(
            Place('footer', len(self._out) - len(footer) - len(MAGIC), len(self._out))
        )

    def _statistics(self) -> Statistics:
        messages = self.written.messages
        times = [message.time_ns for message in messages]
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=dict(
                Counter(self._numbers[message.topic] for message in messages)
            ),
            chunk_count=len(self._chunks),
            message_count=len(messages),
            metadata_count=0,
            message_start_time=min(times),
            message_end_time=max(times),
            schema_count=len(self._schemas),
        )


def _bytes(record) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()
