# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where each message of some mcap files stands, so that any of them is read on its own."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, NamedTuple

from diffcal_ros.recording.mcap_integrity import corrupt, MAGIC, RECORD_HEAD
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Message, MessageIndex, Schema
from mcap.stream_reader import get_chunk_data_stream
from mcap.summary import Summary

_TOP_LEVEL = -1  # Container of a message that stands in no chunk.


class Entry(NamedTuple):
    """Where one message stands.

    Attributes:
        log_time_ns: when it was recorded [ns].
        file: number of the file.
        container: start of the chunk record in the file, or -1.
        offset: start of the message record in the unpacked chunk, or in the file.
    """

    log_time_ns: int
    file: int
    container: int
    offset: int


@dataclass(frozen=True)
class McapIndex:
    """Messages of all files, by topic.

    Attributes:
        files: in the order of recording.
        types: message type of each topic.
        entries: messages of each topic, in the order of recording.
    """

    files: tuple[Path, ...]
    types: dict[str, str] = field(default_factory=dict)
    entries: dict[str, list[Entry]] = field(default_factory=dict)

    def add(self, channel: Channel, schemas: dict[int, Schema], entry: Entry) -> None:
        """Note one message."""
        schema = schemas.get(channel.schema_id)
        self.types.setdefault(channel.topic, '' if schema is None else schema.name)
        self.entries.setdefault(channel.topic, []).append(entry)

    @property
    def message_count(self) -> int:
        """Messages of all topics."""
        return sum(len(entries) for entries in self.entries.values())


def index_files(files: Sequence[Path], whole: Sequence[bool]) -> McapIndex:
    """List the messages of some files.

    Args:
        files: in the order of recording.
        whole: for each file, whether it has its end; of one that was cut off, all messages
            before the cut are listed.

    Raises:
        RecordingError: when a whole file cannot be read as mcap.
    """
    index = McapIndex(tuple(files))
    for number, is_whole in enumerate(whole):
        if not (is_whole and _index_by_summary(index, number)):
            _index_by_scan(index, number, tolerant=not is_whole)
    for entries in index.entries.values():
        # Publishers of one topic may be recorded in chunks of their own.
        entries.sort(key=lambda entry: (entry.file, entry.log_time_ns))
    return index


def unpack_chunk(stream: BinaryIO, start: int) -> bytes:
    """Read the chunk record at `start` and return its unpacked, checked records."""
    stream.seek(start + RECORD_HEAD.size)
    unpacked, length = get_chunk_data_stream(Chunk.read(ReadDataStream(stream)), validate_crc=True)
    return unpacked.read(length)


def read_message(data: bytes, offset: int) -> Message:
    """Read the message record at `offset` of an unpacked chunk."""
    _, length = RECORD_HEAD.unpack_from(data, offset)
    body = data[offset + RECORD_HEAD.size : offset + RECORD_HEAD.size + length]
    message: Message = Message.read(ReadDataStream(BytesIO(body)), length)
    return message


def _index_by_summary(index: McapIndex, number: int) -> bool:
    """Use the index that the file carries; False when it carries none."""
    path = index.files[number]
    try:
        with path.open('rb') as stream:
            summary = make_reader(stream).get_summary()
            if summary is None or not _is_indexed(summary):
                return False
            for chunk in sorted(summary.chunk_indexes, key=lambda item: item.chunk_start_offset):
                for channel_id, offset in chunk.message_index_offsets.items():
                    stream.seek(offset + RECORD_HEAD.size)
                    listed = MessageIndex.read(ReadDataStream(stream))
                    for log_time, inside in listed.records:
                        index.add(
                            summary.channels[channel_id],
                            summary.schemas,
                            Entry(log_time, number, chunk.chunk_start_offset, inside),
                        )
    except (McapError, ValueError, KeyError, OSError, EOFError) as error:
        raise corrupt(path, f'its index cannot be read ({error})') from error
    return True


def _is_indexed(summary: Summary) -> bool:
    """Tell whether every message is reached from the summary."""
    statistics = summary.statistics
    chunks = summary.chunk_indexes
    counted = statistics is None or statistics.message_count == 0 or bool(chunks)
    listed = all(
        chunk.message_index_offsets or chunk.message_start_time == chunk.message_end_time == 0
        for chunk in chunks
    )
    return counted and listed and bool(summary.channels)


def _index_by_scan(index: McapIndex, number: int, *, tolerant: bool) -> None:
    """Walk through the file and unpack every chunk; `tolerant` stops where it is cut off."""
    path = index.files[number]
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    with path.open('rb') as stream:
        try:
            for opcode, start, length in _records(stream):
                if opcode == Opcode.CHUNK:
                    data = unpack_chunk(stream, start)
                    for inner, offset, inner_length in _inner_records(data):
                        body = data[offset + RECORD_HEAD.size :][:inner_length]
                        entry = Entry(0, number, start, offset)
                        _note(index, schemas, channels, inner, body, entry)
                elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
                    stream.seek(start + RECORD_HEAD.size)
                    entry = Entry(0, number, _TOP_LEVEL, start)
                    _note(index, schemas, channels, opcode, stream.read(length), entry)
        except Exception as error:  # Decompressors and parsers raise what they happen to raise.
            if not tolerant:
                raise corrupt(path, f'its records cannot be read ({error})') from error


def _note(
    index: McapIndex,
    schemas: dict[int, Schema],
    channels: dict[int, Channel],
    opcode: int,
    body: bytes,
    entry: Entry,
) -> None:
    stream = ReadDataStream(BytesIO(body))
    if opcode == Opcode.SCHEMA:
        schema = Schema.read(stream)
        schemas[schema.id] = schema
    elif opcode == Opcode.CHANNEL:
        channel = Channel.read(stream)
        channels[channel.id] = channel
    elif opcode == Opcode.MESSAGE:
        found = Message.read(stream, len(body))
        index.add(channels[found.channel_id], schemas, entry._replace(log_time_ns=found.log_time))


def _records(stream: BinaryIO) -> Iterator[tuple[int, int, int]]:
    """Walk over complete records: opcode, start and length of the content."""
    size = stream.seek(0, 2)
    start = len(MAGIC)
    while start + RECORD_HEAD.size <= size:
        stream.seek(start)
        opcode, length = RECORD_HEAD.unpack(stream.read(RECORD_HEAD.size))
        end = start + RECORD_HEAD.size + length
        if end > size or opcode in (Opcode.DATA_END, Opcode.FOOTER):
            return
        yield opcode, start, length
        start = end


def _inner_records(data: bytes) -> Iterator[tuple[int, int, int]]:
    start = 0
    while start + RECORD_HEAD.size <= len(data):
        opcode, length = RECORD_HEAD.unpack_from(data, start)
        yield opcode, start, length
        start += RECORD_HEAD.size + length
