# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which files of a folder are read, and what metadata.yaml says about them."""

import os
import re
import shutil

from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.bag_reader import open_recording
import pytest
import yaml

DEPTH = '/depth/image_rect_raw'


@pytest.fixture
def split(write_bag, depth_images):
    """A bag of two files with six depth images each."""
    path = write_bag(frames=depth_images[:6])
    later = write_bag(name='later', frames=depth_images[6:])
    shutil.copy(later / 'later_0.mcap', path / 'bag_1.mcap')
    change(
        path,
        relative_file_paths=['bag_0.mcap', 'bag_1.mcap'],
        counts={topic: 2 * count for topic, count in counts(path).items()},
    )
    return path


def counts(path):
    told = yaml.safe_load((path / 'metadata.yaml').read_text())['rosbag2_bagfile_information']
    return {
        topic['topic_metadata']['name']: topic['message_count']
        for topic in told['topics_with_message_count']
    }


def change(path, counts=None, **values):
    file = path / 'metadata.yaml'
    content = yaml.safe_load(file.read_text())
    told = content['rosbag2_bagfile_information']
    told.update(values)
    for topic in told['topics_with_message_count'] if counts else ():
        topic['message_count'] = counts[topic['topic_metadata']['name']]
    file.write_text(yaml.safe_dump(content))


def test_a_split_bag_is_read_whole(split):
    recording = open_recording(split)
    assert recording.depth_count == 12
    assert recording.notes == ()


def test_a_missing_file_is_refused_or_counted(split):
    (split / 'bag_1.mcap').unlink()
    with pytest.raises(
        RecordingError, match=r'bag lacks bag_1.mcap, which its metadata.yaml lists: copy the who'
    ):
        open_recording(split)
    recording = open_recording(split, allow_truncated=True)
    assert recording.depth_count == 6
    assert recording.lost_counts[DEPTH] == 6
    assert 'bag_1.mcap, which metadata.yaml lists, is not there' in recording.notes[0]
    assert f'6 of 12 on {DEPTH}' in recording.notes[0]


def test_no_other_file_takes_the_place_of_a_missing_one(split):
    (split / 'bag_1.mcap').rename(split / 'stranger.mcap')
    with pytest.raises(RecordingError, match=r'lacks bag_1.mcap'):
        open_recording(split)
    (split / 'bag_0.mcap').unlink()
    with pytest.raises(RecordingError, match=r'lacks .*the folder holds stranger.mcap'):
        open_recording(split, allow_truncated=True)


def test_a_file_that_is_not_listed_is_told(split):
    shutil.copy(split / 'bag_0.mcap', split / 'stranger.mcap')
    recording = open_recording(split)
    assert recording.depth_count == 12
    assert recording.notes == ('stranger.mcap is not read: metadata.yaml does not list it',)


def test_files_of_several_recordings_are_refused(split):
    (split / 'metadata.yaml').unlink()
    (split / 'bag_1.mcap').rename(split / 'other_1.mcap')
    with pytest.raises(RecordingError, match=r'files of 2 recordings \(bag, other\) and no metad'):
        open_recording(split)


def test_a_file_that_is_listed_twice_is_refused(split):
    change(split, relative_file_paths=['bag_0.mcap', 'bag_0.mcap'])
    with pytest.raises(RecordingError, match=r'metadata.yaml lists bag_0.mcap twice'):
        open_recording(split)


def test_a_copy_of_a_file_is_refused(split):
    shutil.copy(split / 'bag_0.mcap', split / 'bag_1.mcap')
    with pytest.raises(RecordingError, match=r'bag_0.mcap and bag_1.mcap in .* are the same'):
        open_recording(split)
    (split / 'metadata.yaml').unlink()
    with pytest.raises(RecordingError, match='are the same'):
        open_recording(split)


@pytest.mark.parametrize('counted', [11, 13])
def test_another_count_in_the_metadata_is_refused(write_bag, counted):
    path = write_bag()
    change(path, counts={**counts(path), DEPTH: counted})
    with pytest.raises(
        RecordingError, match=rf'counts {counted} messages on {DEPTH} and the files hold 12: copy'
    ):
        open_recording(path)
    recording = open_recording(path, allow_truncated=True)
    assert recording.depth_count == 12
    assert recording.lost_counts == ({DEPTH: 1} if counted > 12 else {})
    assert 'metadata.yaml counts' in recording.notes[0]


def test_the_metadata_counts_what_a_cut_file_has_lost(split):
    file = split / 'bag_1.mcap'
    file.write_bytes(file.read_bytes()[:5000])
    recording = open_recording(split, allow_truncated=True)
    assert recording.lost_counts[DEPTH] == 6
    assert 'is truncated, its end is missing' in recording.notes[0]


@pytest.mark.parametrize('mode', ['NONE', 'none', '', None])
def test_no_compression_may_be_said_in_any_way(write_bag, mode):
    path = write_bag()
    change(path, compression_mode=mode)
    assert open_recording(path).depth_count == 12


def bomb():
    lines = ['a0: &a0 [x, x, x, x, x, x, x, x, x]']
    for k in range(1, 12):
        lines.append(f'a{k}: &a{k} [{", ".join([f"*a{k - 1}"] * 9)}]')
    return '\n'.join([*lines, 'rosbag2_bagfile_information: {storage_identifier: *a11}'])


@pytest.mark.parametrize(
    ('content', 'reason'),
    [
        ('[' * 100_000, r'nested more than 50 deep'),
        (bomb(), 'it holds references'),
        ('x' * (9 << 20), r'no regular file of 8 MB at most'),
        ('a: [', r'cannot be read \('),
        ('rosbag2_bagfile_information: 3', r'cannot be read \('),
        ('\xff', r'cannot be read \('),
    ],
)
def test_metadata_that_cannot_be_read_is_told(write_bag, content, reason):
    path = write_bag()
    (path / 'metadata.yaml').write_bytes(content.encode('latin1'))
    recording = open_recording(path)
    assert recording.depth_count == 12
    (note,) = recording.notes
    assert note.startswith('metadata.yaml cannot be read (')
    assert re.search(reason, note)


@pytest.mark.skipif(not hasattr(os, 'mkfifo'), reason='needs pipes')
@pytest.mark.parametrize('name', ['pipe.mcap', 'bag/bag_0.mcap'])
def test_a_pipe_is_not_waited_for(write_bag, tmp_path, name):
    write_bag()
    (tmp_path / name).unlink(missing_ok=True)
    os.mkfifo(tmp_path / name)
    with pytest.raises(RecordingError, match='is no regular file: give a file that was recorded'):
        open_recording(tmp_path / name.partition('/')[0])


@pytest.mark.skipif(not hasattr(os, 'mkfifo'), reason='needs pipes')
def test_a_pipe_in_place_of_the_metadata_is_told(write_bag):
    path = write_bag()
    (path / 'metadata.yaml').unlink()
    os.mkfifo(path / 'metadata.yaml')
    assert 'is no regular file' in open_recording(path).notes[0]
