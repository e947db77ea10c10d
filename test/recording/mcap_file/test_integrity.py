# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether a file is whole, told from its bytes alone."""

import hashlib
from pathlib import Path

from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.mcap_file.integrity import check_file
from mcap.writer import CompressionType, Writer
import pytest

CONTENT = b'what a camera saw'
FOOTER = 8 + 29  # The last bytes: magic, and the footer with its head.


def written(path: Path, *, has_checksums: bool = True) -> Path:
    with path.open('wb') as stream:
        writer = Writer(
            stream,
            compression=CompressionType.NONE,
            enable_crcs=has_checksums,
            enable_data_crcs=has_checksums,
        )
        writer.start()
        schema = writer.register_schema('Word', 'text', b'')
        channel = writer.register_channel('/words', 'text', schema)
        for number in range(3):
            writer.add_message(channel, number, CONTENT, number)
        writer.finish()
    return path


def changed(path: Path, at: int) -> Path:
    content = bytearray(path.read_bytes())
    content[at] ^= 0x10
    path.write_bytes(content)
    return path


def test_a_whole_file_has_its_end_and_a_sure_summary(tmp_path):
    path = written(tmp_path / 'a.mcap')
    seen = hashlib.sha256()
    ending = check_file(path, seen)
    assert ending.is_whole
    assert ending.problem == ''
    assert ending.is_summary_sure
    content = path.read_bytes()
    assert seen.hexdigest() == hashlib.sha256(content).hexdigest()
    # What follows is the record that ends the data.
    assert content[ending.data_end] == 15


def test_without_checksums_nothing_is_sure(tmp_path):
    ending = check_file(written(tmp_path / 'a.mcap', has_checksums=False), hashlib.sha256())
    assert ending.is_whole
    assert ending.problem == ''
    assert not ending.is_summary_sure


def test_a_changed_message_fails_the_checksum_of_the_data(tmp_path):
    path = written(tmp_path / 'a.mcap')
    changed(path, path.read_bytes().index(CONTENT))
    ending = check_file(path, hashlib.sha256())
    assert ending.problem == f'bytes 0 to {ending.data_end} fail their checksum'
    assert ending.is_summary_sure


def test_a_changed_summary_is_not_sure(tmp_path):
    path = written(tmp_path / 'a.mcap')
    whole = check_file(path, hashlib.sha256())
    ending = check_file(changed(path, path.stat().st_size - FOOTER - 5), hashlib.sha256())
    assert 'fail their checksum' in ending.problem
    assert ending.data_end == whole.data_end
    assert not ending.is_summary_sure


@pytest.mark.parametrize('left', [0.2, 0.6, 0.99])
def test_a_file_that_was_cut_off_has_no_end(tmp_path, left):
    path = written(tmp_path / 'a.mcap')
    content = path.read_bytes()
    path.write_bytes(content[: int(left * len(content))])
    ending = check_file(path, hashlib.sha256())
    assert not ending.is_whole
    assert ending.problem == ''


def test_a_footer_that_points_elsewhere_is_told(tmp_path):
    path = written(tmp_path / 'a.mcap')
    # The start of the summary follows the head of the footer, lowest byte first.
    where = path.stat().st_size - FOOTER + 9
    assert 'does not point' in check_file(changed(path, where), hashlib.sha256()).problem
    far = check_file(changed(path, where + 6), hashlib.sha256())
    assert far.problem == 'its footer points outside the file'
    assert far.data_end == path.stat().st_size


@pytest.mark.parametrize(
    ('content', 'words'), [(b'', 'is empty'), (b'bag of another kind', 'is no mcap file')]
)
def test_what_is_no_recording_is_refused(tmp_path, content, words):
    path = tmp_path / 'a.mcap'
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=words):
        check_file(path, hashlib.sha256())
    with pytest.raises(RecordingError, match='cannot be read'):
        check_file(tmp_path / 'nowhere.mcap', hashlib.sha256())
