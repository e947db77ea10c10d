# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Messages of mcap files, read one by one with one unpacked chunk in memory."""

from collections.abc import Iterator, Sequence
import hashlib
import heapq
from pathlib import Path
from typing import BinaryIO, NamedTuple

from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.mcap_index import Entry, index_files, read_message, unpack_chunk
from diffcal_ros.recording.mcap_integrity import check_file, corrupt, RECORD_HEAD


class RawMessage(NamedTuple):
    """A message as recorded.

    Attributes:
        topic: its topic.
        type_name: for example sensor_msgs/msg/Image.
        log_time_ns: when it was recorded [ns].
        data: CDR bytes.
    """

    topic: str
    type_name: str
    log_time_ns: int
    data: bytes


class McapMessages:
    """Messages of the files of one recording."""

    def __init__(self, files: Sequence[Path], *, allow_truncated: bool = False) -> None:
        """Check the files and list their messages.

        Args:
            files: in the order of recording.
            allow_truncated: take what stands before the cut of a file without its end.

        Raises:
            RecordingError: when a file is empty, cut off, corrupt or no mcap.
        """
        content_hash = hashlib.sha256()
        whole = [check_file(file, content_hash) for file in files]
        self.sha256 = content_hash.hexdigest()
        cut = [file for file, is_whole in zip(files, whole, strict=True) if not is_whole]
        if cut and not allow_truncated:
            raise RecordingError(
                f'{cut[0]} is truncated, its end is missing (the recorder was killed, or the '
                'copy failed): add --allow-truncated to use what stands before the cut, or copy '
                'it again'
            )
        self._index = index_files(files, whole)
        self.saved_count = self._index.message_count if cut else None
        if cut and not self._index.message_count:
            raise RecordingError(
                f'{cut[0]} is truncated and no message stands before the cut: record again'
            )

    @property
    def types(self) -> dict[str, str]:
        """Message type of each topic that has messages."""
        return self._index.types

    def entries(self, topic: str) -> Sequence[Entry]:
        """Return where a topic's messages stand, in the order of recording."""
        return self._index.entries.get(topic, [])

    def read(self, topic: str, entries: Sequence[Entry] | None = None) -> Iterator[RawMessage]:
        """Read messages of one topic, all or the given ones.

        Raises:
            RecordingError: when their bytes have changed.
        """
        for entry, data in self._data(self.entries(topic) if entries is None else entries):
            yield RawMessage(topic, self.types[topic], entry.log_time_ns, data)

    def read_all(self, topics: Sequence[str] | None = None) -> Iterator[RawMessage]:
        """Read messages of several topics in the order of recording; None for all topics."""
        wanted = sorted(self.types) if topics is None else topics
        merged = heapq.merge(
            *([(entry, topic) for entry in self.entries(topic)] for topic in wanted),
            key=lambda pair: (pair[0].file, pair[0].log_time_ns),
        )
        pairs = list(merged)
        data = self._data([entry for entry, _ in pairs])
        for (entry, topic), (_, content) in zip(pairs, data, strict=True):
            yield RawMessage(topic, self.types[topic], entry.log_time_ns, content)

    def _data(self, entries: Sequence[Entry]) -> Iterator[tuple[Entry, bytes]]:
        unpacker = _Unpacker(self._index.files)
        try:
            for entry in entries:
                yield entry, unpacker.read(entry)
        finally:
            unpacker.close()


class _Unpacker:
    """Reads messages and keeps the last file open and the last chunk unpacked."""

    def __init__(self, files: Sequence[Path]) -> None:
        self._files = files
        self._stream: BinaryIO | None = None
        self._opened = -1
        self._unpacked = -1
        self._chunk = b''

    def read(self, entry: Entry) -> bytes:
        path = self._files[entry.file]
        try:
            stream = self._open(entry.file)
            if entry.container < 0:
                return read_message(_top_level(stream, entry.offset), 0).data
            if self._unpacked != entry.container:
                self._chunk = unpack_chunk(stream, entry.container)
                self._unpacked = entry.container
            return read_message(self._chunk, entry.offset).data
        except Exception as error:  # Decompressors and parsers raise what they happen to raise.
            raise corrupt(path, f'a message cannot be unpacked ({error})') from error

    def close(self) -> None:
        if self._stream is not None:
            self._stream.close()

    def _open(self, number: int) -> BinaryIO:
        if self._stream is None or self._opened != number:
            self.close()
            self._stream = self._files[number].open('rb')
            self._opened, self._unpacked = number, -1
        return self._stream


def _top_level(stream: BinaryIO, start: int) -> bytes:
    stream.seek(start)
    head = stream.read(RECORD_HEAD.size)
    _, length = RECORD_HEAD.unpack(head)
    return head + stream.read(length)
