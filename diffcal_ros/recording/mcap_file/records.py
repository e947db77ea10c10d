# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Records of an mcap file: step from one to the next, and look into those that hold messages.

Nothing is taken on trust: a record whose content is not as long as its head says does not fit.
"""

from collections.abc import Iterator
import mmap
import struct
from typing import NamedTuple
import zlib

import lz4.frame  # type: ignore[import-untyped]
from mcap.opcode import Opcode
import zstandard

Bytes = bytes | mmap.mmap

MAGIC = b'\x89MCAP0\r\n'
# A record is one byte of opcode, eight of length, and the content.
RECORD_HEAD = struct.Struct('<BQ')
LARGEST_CHUNK = 1 << 29  # Unpacked [bytes].
MESSAGE_HEAD = struct.Struct('<HIQQ')  # Channel, sequence, log time, publish time.
_CHUNK_HEAD = struct.Struct('<QQQI')  # First and last time, unpacked size, checksum.
_INDEX_HEAD = struct.Struct('<HI')  # Channel, size of the list.
INDEX_ITEM = struct.Struct('<QQ')  # Log time, offset in the unpacked chunk.
_INT = struct.Struct('<I')
_LONG = struct.Struct('<Q')

IN_CHUNK = frozenset((Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE))
IN_DATA = IN_CHUNK | {
    Opcode.HEADER,
    Opcode.CHUNK,
    Opcode.MESSAGE_INDEX,
    Opcode.ATTACHMENT,
    Opcode.METADATA,
    Opcode.DATA_END,
}
IN_SUMMARY = frozenset(
    (
        *(Opcode.DATA_END, Opcode.SCHEMA, Opcode.CHANNEL, Opcode.STATISTICS, Opcode.FOOTER),
        *(Opcode.CHUNK_INDEX, Opcode.ATTACHMENT_INDEX, Opcode.METADATA_INDEX),
        Opcode.SUMMARY_OFFSET,
    )
)
# From here on opcodes are free for private use.
PRIVATE = 0x80


class MisfitError(ValueError):
    """Bytes that are not the record they should be."""


class Record(NamedTuple):
    """Where a record stands.

    Attributes:
        opcode: what it is.
        start: of its head.
        end: behind its content.
    """

    opcode: int
    start: int
    end: int

    @property
    def content(self) -> int:
        """Start of the content."""
        return self.start + RECORD_HEAD.size


class MessageHead(NamedTuple):
    """What stands before a message's data.

    Attributes:
        channel_id: which channel it belongs to.
        log_time_ns: when it was recorded [ns].
    """

    channel_id: int
    log_time_ns: int


def records(data: Bytes, start: int, end: int, kinds: frozenset[int]) -> Iterator[Record]:
    """Step over the records between two places, all of which must fit.

    Raises:
        MisfitError: at the first that does not.
    """
    while start < end:
        record = record_at(data, start, end, kinds)
        yield record
        start = record.end


def record_at(data: Bytes, start: int, end: int, kinds: frozenset[int]) -> Record:
    """Return the record at a place.

    Raises:
        MisfitError: when none of these kinds fits there.
    """
    if start + RECORD_HEAD.size > end:
        raise MisfitError(f'a record at byte {start} is cut off')
    opcode, length = RECORD_HEAD.unpack_from(data, start)
    record = Record(opcode, start, start + RECORD_HEAD.size + length)
    if opcode not in kinds and opcode < PRIVATE:
        raise MisfitError(f'what stands at byte {start} is no record that belongs there')
    if record.end > end:
        raise MisfitError(f'a record at byte {start} reaches beyond the end')
    try:
        is_fitting = _is_fitting(data, record)
    except struct.error:
        is_fitting = False
    if not is_fitting:
        raise MisfitError(f'a record at byte {start} does not hold what it should')
    return record


def message_head(data: Bytes, record: Record) -> MessageHead:
    """Read the channel and the time of a message."""
    channel_id, _, log_time_ns, _ = MESSAGE_HEAD.unpack_from(data, record.content)
    return MessageHead(channel_id, log_time_ns)


def message_data(data: Bytes, record: Record) -> bytes:
    """Return what a message carries."""
    return bytes(data[record.content + MESSAGE_HEAD.size : record.end])


def message_index(data: Bytes, record: Record) -> tuple[int, list[tuple[int, int]]]:
    """Read a message index: its channel, and log time and offset of each message."""
    channel_id, _ = _INDEX_HEAD.unpack_from(data, record.content)
    items = data[record.content + _INDEX_HEAD.size : record.end]
    return channel_id, [(time_ns, offset) for time_ns, offset in INDEX_ITEM.iter_unpack(items)]


def chunk_times(data: Bytes, record: Record) -> tuple[int, int]:
    """Return the first and the last log time in a chunk, as its head tells them [ns]."""
    first, last, _, _ = _CHUNK_HEAD.unpack_from(data, record.content)
    return first, last


def unpack_chunk(data: Bytes, record: Record, *, is_checked: bool = True) -> bytes:
    """Return the records of a chunk, their checksum compared where it is to be.

    Raises:
        ValueError: when they cannot be had, or are too many.
    """
    _, _, size, checksum = _CHUNK_HEAD.unpack_from(data, record.content)
    compression, packed = _chunk_parts(data, record)
    if size > LARGEST_CHUNK:
        raise ValueError(
            f'the chunk at byte {record.start} would unpack to {size / 2**20:.0f} MB, and at most '
            f'{LARGEST_CHUNK / 2**20:.0f} MB are unpacked'
        )
    with memoryview(data) as whole, whole[packed : record.end] as content:
        unpacked = _unpacked(content, compression, size)
    if len(unpacked) != size:
        raise ValueError(f'the chunk at byte {record.start} is not of the size that it tells')
    if is_checked and checksum and zlib.crc32(unpacked) != checksum:
        raise ValueError(f'the chunk at byte {record.start} fails its checksum')
    return unpacked


def _unpacked(packed: memoryview, compression: str, size: int) -> bytes:
    """Unpack no more than one byte over the size, whatever the packed data would yield."""
    if compression == '':
        return bytes(packed)
    if compression == 'zstd':
        unpacker = zstandard.ZstdDecompressor()
        if zstandard.frame_content_size(packed) == size:
            return unpacker.decompress(packed)
        with unpacker.stream_reader(packed) as reader:
            return reader.read(size + 1)
    if compression == 'lz4':
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(packed, max_length=size + 1))
    raise ValueError(f'its chunks are compressed by {compression!r}: zstd and lz4 are read')


def _is_fitting(data: Bytes, record: Record) -> bool:
    """Tell whether the lengths inside a record add up."""
    opcode, place, end = record.opcode, record.content, record.end
    if opcode == Opcode.MESSAGE:
        return place + MESSAGE_HEAD.size <= end
    if opcode == Opcode.CHUNK:
        _chunk_parts(data, record)  # Raises where it does not fit.
        return True
    if opcode == Opcode.MESSAGE_INDEX:
        size = _INDEX_HEAD.unpack_from(data, place)[1]
        return place + _INDEX_HEAD.size + size == end and size % INDEX_ITEM.size == 0
    if opcode == Opcode.SCHEMA:
        return _skipped(data, place + 2, _INT, _INT, _INT) == end
    if opcode == Opcode.CHANNEL:
        return _skipped(data, place + 4, _INT, _INT, _INT) == end
    if opcode == Opcode.METADATA:
        return _skipped(data, place, _INT, _INT) == end
    if opcode == Opcode.ATTACHMENT:
        return _skipped(data, place + 16, _INT, _INT, _LONG) + _INT.size == end
    return opcode != Opcode.DATA_END or place + _INT.size == end


def _skipped(data: Bytes, place: int, *sizes: struct.Struct) -> int:
    """Return the place behind some fields that each tell their length first."""
    for size in sizes:
        place += size.size + int(size.unpack_from(data, place)[0])
        if place > len(data):
            raise struct.error
    return place


def _chunk_parts(data: Bytes, record: Record) -> tuple[str, int]:
    """Return the compression of a chunk, and where its packed records start."""
    place = record.content + _CHUNK_HEAD.size
    packed = _skipped(data, place, _INT) + _LONG.size
    if packed + _LONG.unpack_from(data, packed - _LONG.size)[0] != record.end:
        raise MisfitError(f'the chunk at byte {record.start} is not as long as it tells')
    name = data[place + _INT.size : packed - _LONG.size]
    return bytes(name).decode('ascii', 'backslashreplace'), packed
