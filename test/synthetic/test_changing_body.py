# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A recording of a body whose modulus changes in mid-stream."""

from dataclasses import replace

from diffcal_ros.errors import InputError
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.changing_body import record_changes
from diffcal_ros.synthetic.filming import Timing
import numpy as np
import pytest
from support.recorded_beam import MODULUS, SETTINGS, write_beam_scene

FACTORS = (1.0, 1.5, 1.0)


def test_states_follow_one_another_before_one_camera(tmp_path):
    scene = load_scene(write_beam_scene(tmp_path / 'true', {'marker': ...}))
    settings = replace(SETTINGS, timing=Timing(2), color_frames=0)
    written = load_scene(record_changes(scene, tmp_path / 'out', FACTORS, settings))
    assert written.regions[0].youngs_modulus.start == pytest.approx(1.4 * MODULUS)
    assert written.observations[0].stored_depth_from_world is not None
    recording = open_recording(tmp_path / 'out' / 'bag')
    frames = list(recording.depth_frames())
    stamps = np.array([frame.stamp_ns for frame in frames])
    np.testing.assert_array_equal(np.diff(stamps), round(1e9 / settings.timing.rate))
    first, second, third = (frames[2 * state].depth for state in range(3))
    body = np.isfinite(first) & (first < np.nanquantile(first, 0.05) + 0.1)

    def differing(one, other) -> int:
        """Count pixels that differ by more than noise, where the body is."""
        return int(np.count_nonzero(np.abs(one - other)[body] > 0.003))

    noise = differing(first, frames[1].depth)
    assert differing(first, third) < 2 * noise + 20
    assert differing(first, second) > 5 * noise + 100


def test_what_cannot_be_recorded_is_refused(tmp_path):
    scene = load_scene(write_beam_scene(tmp_path / 'true'))
    with pytest.raises(InputError, match='give at least one, above zero'):
        record_changes(scene, tmp_path / 'out', (1.0, -1.0), SETTINGS)
    with pytest.raises(ValueError, match='only one read from a file'):
        record_changes(replace(scene, path=None), tmp_path / 'out', FACTORS, SETTINGS)
