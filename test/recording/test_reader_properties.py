# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whatever the bytes: the reader reads them or says in a sentence why not."""

from diffcal_ros.errors import InputError
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.topics.compressed_depth import decode_compressed_depth
import numpy as np
import pytest
from support.packed_depth import PNG, png, RVL, rvl
from support.properties import many

hypothesis = pytest.importorskip('hypothesis', reason='hypothesis is not installed')
given = hypothesis.given
st = pytest.importorskip('hypothesis.strategies')
numpy_strategies = pytest.importorskip('hypothesis.extra.numpy')

_MANY = many(60)
_LONGEST = 1600
images = numpy_strategies.arrays(
    np.uint16,
    numpy_strategies.array_shapes(min_dims=2, max_dims=2, max_side=40),
    elements=st.integers(0, 65535),
)


@pytest.fixture
def content(write_bag, depth_images):
    (file,) = write_bag(frames=depth_images[:3]).glob('*.mcap')
    return file.read_bytes()


def tried(work):
    """Return what came of some work, and what was refused."""
    try:
        return work(), ''
    except InputError as error:
        return None, str(error)


def count_depth(file, is_tolerant) -> float:
    """Count the depth images that are read, and those that are told to be lost or left out."""
    recording = open_recording(file, allow_truncated=is_tolerant)
    frames = list(recording.depth_frames())
    if 'not known' in ' '.join(recording.notes):
        return float('inf')
    lost = recording.lost_counts.get(recording.depth_topic, 0)
    return len(frames) + lost + sum(recording.skipped.values())


@_MANY
@given(image=images, kind=st.sampled_from([PNG, RVL]))
def test_packed_images_come_out_as_they_went_in(image, kind):
    packed = (png if kind == PNG else rvl)(image)
    np.testing.assert_array_equal(decode_compressed_depth(packed, kind), image)


@_MANY
@given(image=images, kind=st.sampled_from([PNG, RVL]), data=st.data())
def test_packed_images_of_any_bytes_are_read_or_refused(image, kind, data):
    packed = bytearray((png if kind == PNG else rvl)(image))
    start = data.draw(st.integers(0, len(packed)))
    end = data.draw(st.integers(start, len(packed)))
    packed[start:end] = data.draw(st.binary(max_size=60))
    found, problem = tried(lambda: decode_compressed_depth(bytes(packed), kind))
    assert 'compressed depth image' in problem or found.dtype == np.uint16


@_MANY
@given(data=st.data())
def test_a_file_with_any_bytes_in_it_is_read_or_refused(content, tmp_path, data):
    spoilt = bytearray(content)
    start = data.draw(st.integers(0, len(spoilt)))
    end = data.draw(st.integers(start, min(start + 5000, len(spoilt))))
    spoilt[start:end] = data.draw(st.binary(max_size=200))
    file = tmp_path / 'spoilt.mcap'
    file.write_bytes(spoilt)
    for is_tolerant in (False, True):
        count, problem = tried(lambda is_tolerant=is_tolerant: count_depth(file, is_tolerant))
        assert not problem or 'spoilt.mcap' in problem or '/depth' in problem
        assert len(problem) < _LONGEST
        assert problem or count >= 3


@_MANY
@given(content=st.binary(max_size=300))
def test_a_file_of_any_bytes_is_refused(tmp_path, content):
    file = tmp_path / 'anything.mcap'
    file.write_bytes(content)
    with pytest.raises(InputError, match=r'anything\.mcap'):
        open_recording(file, allow_truncated=True)
