# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is left of a damaged or cut-off mcap file, and what of it is lost."""

from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from diffcal_ros.recording.mcap_file.index import (
    FileIndex,
    is_described_otherwise,
    open_bytes,
    read_summary,
    TOP_LEVEL,
)
from diffcal_ros.recording.mcap_file.integrity import Ending
from diffcal_ros.recording.mcap_file.records import (
    Bytes,
    chunk_times,
    IN_CHUNK,
    IN_SUMMARY,
    MAGIC,
    message_index,
    Record,
    records,
    unpack_chunk,
)
from diffcal_ros.recording.mcap_file.rescue import Gap, Rescue
from mcap.opcode import Opcode
from mcap.summary import Summary

# Messages of a channel that nothing describes.
UNKNOWN_TOPIC = 'an unknown topic'


@dataclass
class Rescued:
    """What a file still holds.

    Attributes:
        index: messages that can be read.
        lost: messages that cannot, by topic, as far as the file tells.
        is_counted: whether the file tells how many there should be.
        spoilt: places that cannot be read.
        problem: what is wrong with the file; empty where nothing is.
    """

    index: FileIndex
    lost: Counter[str] = field(default_factory=Counter)
    is_counted: bool = False
    spoilt: int = 0
    problem: str = ''


def rescue(path: Path, number: int, ending: Ending) -> Rescued:
    """Read all that can be read of a file, whatever happened to it.

    Args:
        path: the file.
        number: of the file in its bag.
        ending: how the file ends.
    """
    summary = _summary(path, ending)
    rescued = Rescued(FileIndex(number, dict(summary.schemas), dict(summary.channels)))
    _walk(path, rescued)
    is_doubtful = _settle(rescued, summary, ending)
    _count(rescued, summary)
    rescued.is_counted &= not is_doubtful
    if not ending.is_whole:
        rescued.problem = 'is truncated, its end is missing'
    elif rescued.spoilt or rescued.lost:
        rescued.problem = 'is damaged'
    elif ending.problem:
        rescued.problem = f'is damaged, {ending.problem}, and nothing tells where'
    return rescued


def _summary(path: Path, ending: Ending) -> Summary:
    if ending.data_end is None:
        return Summary()
    try:
        return read_summary(path) or Summary()
    except Exception:  # Parsers raise what they happen to raise.
        return _descriptions(path, ending.data_end)


def _descriptions(path: Path, data_end: int) -> Summary:
    """Take the topics and types out of a summary that cannot be read as a whole."""
    data, index = open_bytes(path), FileIndex(0)
    with suppress(Exception):  # Likewise.
        for record in records(data, data_end, len(data) - len(MAGIC), IN_SUMMARY):
            if record.opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                index.add(data, record)
    summary = Summary()
    summary.schemas, summary.channels = index.schemas, index.channels
    return summary


def _walk(path: Path, rescued: Rescued) -> None:
    data, index = open_bytes(path), rescued.index
    has_chunks = False
    announcements = _Announcements(data)
    for step in Rescue(data, len(MAGIC), index.channels).steps():
        if isinstance(step, Gap):
            rescued.spoilt += 1
            announcements.chunk = None
            continue
        try:
            if step.opcode == Opcode.CHUNK:
                has_chunks = True
                announcements.chunk = chunk_times(data, step)
                index.add_chunk(data, step)
            elif step.opcode == Opcode.MESSAGE_INDEX and not announcements.is_credible(step):
                rescued.spoilt += 1
            else:
                index.add(data, step)
        except Exception:  # Decompressors and parsers raise what they happen to raise.
            rescued.spoilt += 1
            _take_descriptions(data, step, index)
    if has_chunks and rescued.spoilt:
        # What seems to stand between chunks is the inside of a damaged one, and unchecked.
        for channel_id, entries in index.entries.items():
            index.entries[channel_id] = [item for item in entries if item.container != TOP_LEVEL]


class _Announcements:
    """Judges message indexes, which have no checksum.

    Attributes:
        chunk: first and last time in the chunk before them [ns]; None where it is not known.
    """

    def __init__(self, data: Bytes) -> None:
        self._data = data
        self._known: set[int] = set()
        self.chunk: tuple[int, int] | None = None

    def is_credible(self, record: Record) -> bool:
        """Tell whether an index is of its chunk's time, and stands here for the first time."""
        content = hash(bytes(self._data[record.content : record.end]))
        if content in self._known:
            return False
        self._known.add(content)
        if self.chunk is None:
            return True
        first, last = self.chunk
        _, items = message_index(self._data, record)
        return all(first <= time_ns <= last for time_ns, _ in items)


def _take_descriptions(data: Bytes, chunk: Record, index: FileIndex) -> None:
    """Learn topics and types from a damaged chunk: the first one describes those of the others."""
    known = dict(index.channels), dict(index.schemas)
    with suppress(Exception):  # Decompressors and parsers raise what they happen to raise.
        unpacked = unpack_chunk(data, chunk, is_checked=False)
        for record in records(unpacked, 0, len(unpacked), IN_CHUNK):
            if record.opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                index.add(unpacked, record)
    index.channels.update(known[0])
    index.schemas.update(known[1])


def _settle(rescued: Rescued, summary: Summary, ending: Ending) -> bool:
    """Choose where data and summary describe a channel differently; tell if that is a guess."""
    index = rescued.index
    if not is_described_otherwise(index, summary):
        return False
    rescued.spoilt += 1
    if ending.is_summary_sure:
        index.channels.update(summary.channels)
        index.schemas.update(summary.schemas)
    return not ending.is_summary_sure


def _count(rescued: Rescued, summary: Summary) -> None:
    """Compare what was found with what statistics, or else message indexes, announce."""
    index = rescued.index
    for channel_id in set(index.entries) - set(index.channels):
        rescued.lost[UNKNOWN_TOPIC] += len(index.entries.pop(channel_id))
    counts = index.counts
    told = _told(summary)
    if told is not None and index.announced and set(told) - set(index.channels):
        told = None  # They count a channel that nothing describes: the other account is better.
    rescued.is_counted = told is not None
    if told is None:
        for channel_id, times in index.announced.items():
            found = Counter(entry.log_time_ns for entry in index.entries.get(channel_id, []))
            rescued.lost[_topic(index, channel_id)] += (times - found).total()
    else:
        rescued.lost.clear()
        for channel_id, count in told.items():
            rescued.lost[_topic(index, channel_id)] += max(count - counts.get(channel_id, 0), 0)
    rescued.lost = +rescued.lost


def _told(summary: Summary) -> dict[int, int] | None:
    """Return what the statistics count, None where they do not add up."""
    statistics = summary.statistics
    if statistics is None or not statistics.channel_message_counts:
        return None
    counts = dict(statistics.channel_message_counts)
    return counts if sum(counts.values()) == statistics.message_count else None


def _topic(index: FileIndex, channel_id: int) -> str:
    channel = index.channels.get(channel_id)
    return UNKNOWN_TOPIC if channel is None else str(channel.topic)
