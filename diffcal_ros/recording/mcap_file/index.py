# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where each message of an mcap file stands, so that any of them is read on its own."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from io import BytesIO
import mmap
from pathlib import Path
from typing import NamedTuple

from diffcal_ros.recording.mcap_file.integrity import corrupt, Ending
from diffcal_ros.recording.mcap_file.records import (
    Bytes,
    IN_CHUNK,
    IN_DATA,
    MAGIC,
    message_head,
    message_index,
    PRIVATE,
    Record,
    record_at,
    records,
    unpack_chunk,
)
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Schema
from mcap.summary import Summary

TOP_LEVEL = -1  # Container of a message that stands in no chunk.


class Entry(NamedTuple):
    """Where one message stands.

    Attributes:
        log_time_ns: when it was recorded [ns].
        file: number of the file.
        container: start of the chunk record in the file, or -1.
        offset: start of the message record in the unpacked chunk, or in the file.
        channel_id: number of its channel in the file.
    """

    log_time_ns: int
    file: int
    container: int
    offset: int
    channel_id: int


@dataclass
class FileIndex:
    """Messages of one file.

    Attributes:
        number: of the file.
        schemas: by number.
        channels: by number.
        entries: of each channel, in the order in which they stand.
        announced: log times that message indexes tell, by channel.
        has_unknown: whether there are records of a kind that is not known.
    """

    number: int
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    entries: dict[int, list[Entry]] = field(default_factory=dict)
    announced: dict[int, Counter[int]] = field(default_factory=dict)
    has_unknown: bool = False

    @property
    def counts(self) -> dict[int, int]:
        """Messages of each channel."""
        return {number: len(entries) for number, entries in self.entries.items()}

    def add(self, data: Bytes, record: Record, container: int = TOP_LEVEL) -> None:
        """Take note of a record in the data section or in a chunk.

        Raises:
            ValueError: when a channel or schema cannot be read.
        """
        if record.opcode == Opcode.SCHEMA:
            schema = Schema.read(_content(data, record))
            self.schemas[schema.id] = schema
        elif record.opcode == Opcode.CHANNEL:
            channel = Channel.read(_content(data, record))
            self.channels[channel.id] = channel
        elif record.opcode == Opcode.MESSAGE:
            channel_id, time_ns = message_head(data, record)
            entry = Entry(time_ns, self.number, container, record.start, channel_id)
            self.entries.setdefault(channel_id, []).append(entry)
        elif record.opcode == Opcode.MESSAGE_INDEX:
            channel_id, items = message_index(data, record)
            self.announced.setdefault(channel_id, Counter()).update(time for time, _ in items)
        elif record.opcode >= PRIVATE:
            self.has_unknown = True

    def add_chunk(self, data: Bytes, record: Record) -> None:
        """Take note of what a chunk holds, all or nothing.

        Raises:
            ValueError: when it cannot be unpacked or read.
        """
        unpacked = unpack_chunk(data, record)
        inner = list(records(unpacked, 0, len(unpacked), IN_CHUNK))
        for found in inner:
            self.add(unpacked, found, record.start)


def index_whole(path: Path, number: int, ending: Ending) -> FileIndex:
    """List the messages of a file that has its end.

    Args:
        path: the file.
        number: of the file in its bag.
        ending: how it ends.

    Raises:
        RecordingError: when it cannot be read as mcap, or holds not what it tells.
    """
    try:
        data = open_bytes(path)
        summary = read_summary(path) or Summary()
        counted = dict(summary.statistics.channel_message_counts) if summary.statistics else {}
        index = None
        if counted and ending.is_summary_sure:
            index = _from_summary(data, number, summary)
        if index is None:
            index = _from_data(data, number, ending.data_end or len(data))
            _check_announced(index)
            if is_described_otherwise(index, summary):
                raise ValueError('it describes a topic in two ways')
        _check_counts(index, counted)
        if summary.statistics and summary.statistics.message_count != sum(index.counts.values()):
            raise ValueError('it counts another number of messages')
    except Exception as error:  # Parsers raise what they happen to raise.
        raise corrupt(path, f'its records cannot be read ({error})') from error
    return index


def open_bytes(path: Path) -> mmap.mmap:
    """Map a file into memory, to be read."""
    with path.open('rb') as stream:
        return mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)


def read_summary(path: Path) -> Summary | None:
    """Read what stands behind the data, None where nothing does."""
    with path.open('rb') as stream:
        summary: Summary | None = make_reader(stream).get_summary()
        return summary


def _from_summary(data: Bytes, number: int, summary: Summary) -> FileIndex | None:
    """Use the index that the file carries; None when it does not lead to every message."""
    index = FileIndex(number, dict(summary.schemas), dict(summary.channels))
    for chunk in sorted(summary.chunk_indexes, key=lambda item: item.chunk_start_offset):
        for offset in chunk.message_index_offsets.values():
            place = record_at(data, offset, len(data), IN_DATA)
            channel_id, items = message_index(data, place)
            index.entries.setdefault(channel_id, []).extend(
                Entry(time_ns, number, chunk.chunk_start_offset, inside, channel_id)
                for time_ns, inside in items
            )
    assert summary.statistics is not None
    if index.counts != _positive(summary.statistics.channel_message_counts):
        return None
    places = {entry[2:4] for entries in index.entries.values() for entry in entries}
    if len(places) < sum(index.counts.values()) or set(index.counts) - set(index.channels):
        return None
    return index


def _from_data(data: Bytes, number: int, data_end: int) -> FileIndex:
    """Walk through the file and unpack every chunk."""
    index = FileIndex(number)
    for record in records(data, len(MAGIC), data_end, IN_DATA):
        if record.opcode == Opcode.CHUNK:
            index.add_chunk(data, record)
        else:
            index.add(data, record)
    return index


def _check_announced(index: FileIndex) -> None:
    for channel_id, times in index.announced.items():
        found = Counter(entry.log_time_ns for entry in index.entries.get(channel_id, []))
        if times != found:
            raise ValueError('the index of its messages does not fit to them')


def _check_counts(index: FileIndex, counted: Mapping[int, int]) -> None:
    for channel_id in index.entries:
        if channel_id not in index.channels:
            raise ValueError(f'messages belong to a channel {channel_id} that is not described')
    if counted and index.counts != _positive(counted):
        told, found = sum(counted.values()), sum(index.counts.values())
        raise ValueError(
            f'{found} messages stand in it and it counts {told}, or they are of other topics'
        )
    if not counted and index.has_unknown:
        raise ValueError('records of an unknown kind stand in it, and nothing counts the others')


def is_described_otherwise(index: FileIndex, summary: Summary) -> bool:
    """Tell whether the summary describes a channel or a type otherwise than the data."""
    return any(
        mine.get(number, told) != told
        for mine, theirs in (
            (index.channels, summary.channels),
            (index.schemas, summary.schemas),
        )
        for number, told in theirs.items()
    )


def _positive(counts: Mapping[int, int]) -> dict[int, int]:
    return {number: count for number, count in counts.items() if count}


def _content(data: Bytes, record: Record) -> ReadDataStream:
    return ReadDataStream(BytesIO(bytes(data[record.content : record.end])))
