# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Messages of mcap files, read one by one with few unpacked chunks in memory."""

from collections import OrderedDict
from collections.abc import Iterator, Sequence
import hashlib
import heapq
import mmap
from pathlib import Path
from typing import NamedTuple

from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.bag.bag_contents import BagContents
from diffcal_ros.recording.bag.bag_files import BagFiles
from diffcal_ros.recording.mcap_file.damage import rescue
from diffcal_ros.recording.mcap_file.index import Entry, index_whole, open_bytes, TOP_LEVEL
from diffcal_ros.recording.mcap_file.integrity import check_file, corrupt
from diffcal_ros.recording.mcap_file.records import (
    Bytes,
    IN_CHUNK,
    IN_DATA,
    message_data,
    message_head,
    MisfitError,
    record_at,
    unpack_chunk,
)

# A message and the one to be read beside it may stand in two chunks.
_KEPT_CHUNKS = 2


class RawMessage(NamedTuple):
    """A message as recorded.

    Attributes:
        topic: its topic.
        type_name: for example sensor_msgs/msg/Image.
        log_time_ns: when it was recorded [ns].
        data: CDR bytes.
        entry: where it stands.
    """

    topic: str
    type_name: str
    log_time_ns: int
    data: bytes
    entry: Entry


class McapMessages:
    """Messages of the files of one recording."""

    def __init__(self, bag: BagFiles, *, allow_truncated: bool = False) -> None:
        """Check the files and list their messages.

        Args:
            bag: the files.
            allow_truncated: take what can be read of damaged, cut-off and missing files.

        Raises:
            RecordingError: when a file is empty, cut off, corrupt, missing or no mcap.
        """
        self._files = bag.files
        self._contents = BagContents(bag)
        content_hash = hashlib.sha256()
        for number, file in enumerate(bag.files):
            ending = check_file(file, content_hash)
            if allow_truncated:
                self._contents.add_rescued(file, rescue(file, number, ending))
                continue
            if ending.data_end is None:
                raise RecordingError(
                    f'{file} is truncated, its end is missing (the recorder was killed, or the '
                    'copy failed): add --allow-truncated to use what stands before the cut, or '
                    'copy it again'
                )
            if ending.problem:
                raise corrupt(file, ending.problem)
            self._contents.add(index_whole(file, number, ending))
        self._contents.finish(is_strict=not allow_truncated)
        self.sha256 = content_hash.hexdigest()

    @property
    def types(self) -> dict[str, str]:
        """Message type of each topic that has messages."""
        return self._contents.types

    @property
    def notes(self) -> tuple[str, ...]:
        """What is damaged or missing, in sentences."""
        return self._contents.notes

    @property
    def saved_count(self) -> int | None:
        """Messages that can be read of a damaged recording; None for a whole one."""
        return self._contents.saved_count

    @property
    def lost(self) -> dict[str, int]:
        """Messages that cannot be read, by topic, as far as the recording tells."""
        return dict(self._contents.lost)

    def entries(self, topic: str) -> Sequence[Entry]:
        """Return where a topic's messages stand, in the order of recording."""
        return self._contents.entries.get(topic, [])

    def read(self, topic: str, entries: Sequence[Entry] | None = None) -> Iterator[RawMessage]:
        """Read messages of one topic, all or the given ones.

        Raises:
            RecordingError: when their bytes have changed.
        """
        for entry, data in self._data(self.entries(topic) if entries is None else entries):
            yield RawMessage(topic, self.types[topic], entry.log_time_ns, data, entry)

    def read_all(self, topics: Sequence[str] | None = None) -> Iterator[RawMessage]:
        """Read messages of several topics in the order of recording; None for all topics."""
        wanted = sorted(self.types) if topics is None else topics
        merged = heapq.merge(
            *([(entry, topic) for entry in self.entries(topic)] for topic in wanted),
            key=lambda pair: (pair[0].file, pair[0].log_time_ns),
        )
        yield from self.read_each([(topic, entry) for entry, topic in merged])

    def read_each(self, places: Sequence[tuple[str, Entry]]) -> Iterator[RawMessage]:
        """Read messages of any topics, in the order given.

        Raises:
            RecordingError: when their bytes have changed.
        """
        data = self._data([entry for _, entry in places])
        for (topic, _), (entry, content) in zip(places, data, strict=True):
            yield RawMessage(topic, self.types[topic], entry.log_time_ns, content, entry)

    def _data(self, entries: Sequence[Entry]) -> Iterator[tuple[Entry, bytes]]:
        unpacker = _Unpacker(self._files)
        for entry in entries:
            yield entry, unpacker.read(entry)


class _Unpacker:
    """Reads messages and keeps the last file open and the last chunks unpacked."""

    def __init__(self, files: Sequence[Path]) -> None:
        self._files = files
        self._opened = -1
        self._file: mmap.mmap | None = None
        self._chunks: OrderedDict[int, bytes] = OrderedDict()

    def read(self, entry: Entry) -> bytes:
        path = self._files[entry.file]
        try:
            data, kinds = self._around(entry), IN_CHUNK
            if entry.container == TOP_LEVEL:
                kinds = IN_DATA
            record = record_at(data, entry.offset, len(data), kinds)
            if message_head(data, record) != (entry.channel_id, entry.log_time_ns):
                raise MisfitError('its index leads to another message')
            return message_data(data, record)
        except Exception as error:  # Decompressors and parsers raise what they happen to raise.
            raise corrupt(path, f'a message cannot be unpacked ({error})') from error

    def _around(self, entry: Entry) -> Bytes:
        """Return what a message stands in: an unpacked chunk, or the file."""
        if self._file is None or self._opened != entry.file:
            self._file, self._opened = open_bytes(self._files[entry.file]), entry.file
            self._chunks.clear()
        if entry.container == TOP_LEVEL:
            return self._file
        if entry.container not in self._chunks:
            record = record_at(self._file, entry.container, len(self._file), IN_DATA)
            self._chunks[entry.container] = unpack_chunk(self._file, record)
            if len(self._chunks) > _KEPT_CHUNKS:
                self._chunks.popitem(last=False)
        return self._chunks[entry.container]
