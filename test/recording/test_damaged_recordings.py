# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A damaged recording is refused, or on request read in part with all losses counted."""

from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.bag_reader import open_recording
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, IndexType
import numpy as np
import pytest

DEPTH = '/depth/image_rect_raw'
# As rosbag2's profile `fastwrite` records: statistics, but neither chunks nor checksums.
FASTWRITE = {'use_chunking': False, 'enable_crcs': False, 'index_types': IndexType.NONE}
CHUNKED = {'chunk_size': 20_000, 'compression': CompressionType.NONE}


@pytest.fixture
def chunked(write_bag, rewrite):
    """Twelve depth images in as many chunks and more."""
    return rewrite(write_bag(), **CHUNKED)


def chunks_of(path):
    with path.open('rb') as stream:
        return make_reader(stream).get_summary().chunk_indexes


def topics_of(path, chunk):
    with path.open('rb') as stream:
        channels = make_reader(stream).get_summary().channels
        return [channels[number].topic for number in chunk.message_index_offsets]


def flip(path, place, mask=0x10):
    content = bytearray(path.read_bytes())
    content[place] ^= mask
    path.write_bytes(content)


def zero(path, start, end):
    content = bytearray(path.read_bytes())
    content[start:end] = bytes(end - start)
    path.write_bytes(content)


def read_numbers(recording, images):
    """Tell which of the images were read, by their pixels."""
    return [
        next(k for k, image in enumerate(images) if np.array_equal(frame.depth, image, True))
        for frame in recording.depth_frames()
    ]


def test_a_damaged_chunk_is_left_out_and_what_follows_is_read(chunked, depth_images):
    spoilt = [one for one in chunks_of(chunked) if DEPTH in topics_of(chunked, one)][3]
    flip(chunked, spoilt.chunk_start_offset + spoilt.chunk_length // 2)
    with pytest.raises(RecordingError, match=r'is corrupt, .*add --allow-truncated to use what'):
        list(open_recording(chunked).depth_frames())
    recording = open_recording(chunked, allow_truncated=True)
    found = read_numbers(recording, depth_images)
    assert len(found) == 12 - recording.lost_counts[DEPTH] >= 10
    assert found[-1] == 11
    count = recording.lost_counts[DEPTH]
    assert recording.saved_count == 50 - sum(recording.lost_counts.values())
    (note,) = recording.notes
    assert f'{recording.saved_count} messages can be read, lost are ' in note
    assert f'{count} of 12 on {DEPTH}' in note


@pytest.mark.parametrize('reach', [9, 60, 3000])
def test_a_chunk_without_its_head_is_left_out(chunked, depth_images, reach):
    spoilt = [one for one in chunks_of(chunked) if DEPTH in topics_of(chunked, one)][3]
    zero(chunked, spoilt.chunk_start_offset, spoilt.chunk_start_offset + reach)
    recording = open_recording(chunked, allow_truncated=True)
    found = read_numbers(recording, depth_images)
    assert len(found) == 12 - recording.lost_counts[DEPTH] >= 10
    assert found[-1] == 11


def test_what_message_indexes_announce_is_counted_in_a_file_without_its_end(chunked, depth_images):
    spoilt = [one for one in chunks_of(chunked) if DEPTH in topics_of(chunked, one)][3]
    flip(chunked, spoilt.chunk_start_offset + spoilt.chunk_length // 2)
    chunked.write_bytes(chunked.read_bytes()[:-300])
    recording = open_recording(chunked, allow_truncated=True)
    assert len(read_numbers(recording, depth_images)) == 12 - recording.lost_counts[DEPTH]
    assert 'known to be lost are 2 of 12 on' in recording.notes[0]
    assert 'how many are lost in all is not known' in recording.notes[0]


def test_the_first_chunk_tells_the_topics_of_the_others(chunked, depth_images):
    first = min(chunks_of(chunked), key=lambda one: one.chunk_start_offset)
    flip(chunked, first.chunk_start_offset + first.chunk_length - 50)
    chunked.write_bytes(chunked.read_bytes()[:-300])
    recording = open_recording(chunked, allow_truncated=True)
    assert read_numbers(recording, depth_images)[-1] == 11


def message_places(path):
    """Return where each message's record starts in a file without chunks."""
    places = []
    with path.open('rb') as stream:
        reader = StreamReader(stream)
        for record in reader.records:
            if type(record).__name__ == 'Message':
                places.append((reader._stream.count - 31 - len(record.data), record))
    return places


def depth_places(path):
    largest = max(len(record.data) for _, record in message_places(path))
    return [place for place, record in message_places(path) if len(record.data) == largest]


# Of a record's head: opcode, length, channel.
@pytest.mark.parametrize('place', [0, 1, 2, 5, 9])
@pytest.mark.parametrize('mask', [0x01, 0x10, 0x80])
def test_one_flipped_bit_in_a_file_without_chunks_loses_no_frame_unsaid(
    write_bag, rewrite, depth_images, place, mask
):
    file = rewrite(write_bag(), **FASTWRITE)
    flip(file, depth_places(file)[2] + place, mask)
    with pytest.raises(RecordingError, match=r'other.mcap is corrupt, its records cannot be read'):
        open_recording(file)
    recording = open_recording(file, allow_truncated=True)
    found = read_numbers(recording, depth_images)
    assert found == [k for k in range(12) if k != 2]
    # What became too short is there and no image.
    assert recording.lost_counts.get(DEPTH, 0) + sum(recording.skipped.values()) == 1
    assert 'is damaged: ' in recording.notes[0]


def test_a_topic_that_changed_its_name_is_noticed(write_bag, rewrite):
    file = rewrite(write_bag(), **FASTWRITE)
    flip(file, file.read_bytes().index(DEPTH.encode()) + 9, 0x01)
    with pytest.raises(RecordingError, match='describes a topic in two ways'):
        open_recording(file)


def test_records_of_an_unknown_kind_are_noticed_where_nothing_counts(write_bag, rewrite):
    bare = {'use_statistics': False, 'repeat_channels': False, 'repeat_schemas': False}
    file = rewrite(write_bag(), **FASTWRITE, **bare)
    assert open_recording(file).depth_count == 12
    flip(file, depth_places(file)[2], 0x80)
    with pytest.raises(RecordingError, match='records of an unknown kind'):
        open_recording(file)


def index_places(path):
    """Return start and end of each message index that is not empty."""
    places = []
    with path.open('rb') as stream:
        reader = StreamReader(stream)
        for record in reader.records:
            if type(record).__name__ == 'MessageIndex' and record.records:
                end = reader._stream.count
                places.append((end - 9 - 6 - 16 * len(record.records), end))
    return places


def cut_out_summary(content):
    """Spoil the footer's place of the summary: only message indexes announce anything then."""
    footer = len(content) - 8 - 29
    content[footer + 9 : footer + 17] = (1 << 40).to_bytes(8, 'little')


def test_an_index_that_stands_twice_announces_once(chunked, depth_images):
    start, end = index_places(chunked)[4]
    content = bytearray(chunked.read_bytes())
    assert content[start] == Opcode.MESSAGE_INDEX
    content[end:end] = content[start:end]
    cut_out_summary(content)
    chunked.write_bytes(content)
    recording = open_recording(chunked, allow_truncated=True)
    assert read_numbers(recording, depth_images) == list(range(12))
    assert recording.lost_counts == {}
    assert 'is damaged: 50 messages can be read; how many' in recording.notes[0]


def test_an_index_of_another_time_than_its_chunk_announces_nothing(chunked, depth_images):
    start, _ = index_places(chunked)[4]
    content = bytearray(chunked.read_bytes())
    content[start + 9 + 6 + 7] ^= 0x40
    cut_out_summary(content)
    chunked.write_bytes(content)
    recording = open_recording(chunked, allow_truncated=True)
    assert read_numbers(recording, depth_images) == list(range(12))
    assert recording.lost_counts == {}
    assert 'is damaged: 50 messages can be read' in recording.notes[0]


@pytest.mark.parametrize('spoilt', ['its counts', 'its length'])
def test_topics_are_named_by_what_is_left_of_the_summary(chunked, spoilt):
    with chunked.open('rb') as stream:
        summary = make_reader(stream).get_summary()
    first = min(summary.chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)
    topics = {channel.topic: number for number, channel in summary.channels.items()}
    names = topics_of(chunked, first)
    counts = b''.join(
        number.to_bytes(2, 'little') + count.to_bytes(8, 'little')
        for number, count in summary.statistics.channel_message_counts.items()
    )
    content = bytearray(chunked.read_bytes())
    place = content.index(counts)
    if spoilt == 'its counts':
        # Of a channel that is not there.
        lost = topics[names[0]].to_bytes(2, 'little')
        entry = next(k for k in range(0, len(counts), 10) if counts[k : k + 2] == lost)
        content[place + entry + 1] ^= 0x20
    else:
        content[place - 1] ^= 0x40
    # The chunk that describes the first topics cannot be unpacked, nor its records be read.
    content[first.chunk_start_offset + 60 : first.chunk_start_offset + 400] = bytes(340)
    chunked.write_bytes(content)
    recording = open_recording(chunked, allow_truncated=True)
    assert set(names) <= set(recording.lost_counts) <= set(topics)
    assert sum(recording.lost_counts.values()) == 50 - recording.saved_count


def test_a_sound_recording_has_no_losses(chunked, depth_images):
    recording = open_recording(chunked, allow_truncated=True)
    assert read_numbers(recording, depth_images) == list(range(12))
    assert recording.saved_count is None
    assert recording.notes == ()
    assert recording.lost_counts == {}
