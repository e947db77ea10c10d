# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A recording of a body that changes in mid-stream."""

from dataclasses import replace

from diffcal_ros.errors import InputError
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.changing_body import BodyState, record_changes
from diffcal_ros.synthetic.filming import Timing
import numpy as np
import pytest
from support.recorded_beam import MODULUS, SETTINGS, write_beam_scene

STATES = (BodyState(), BodyState(1.5), BodyState(), BodyState(payload=0.01))


def test_states_follow_one_another_before_one_camera(tmp_path):
    scene = load_scene(write_beam_scene(tmp_path / 'true', {'marker': ...}))
    settings = replace(SETTINGS, timing=Timing(2), color_frames=0)
    written = load_scene(record_changes(scene, tmp_path / 'out', STATES, settings))
    assert written.regions[0].youngs_modulus.start == pytest.approx(1.4 * MODULUS)
    assert written.observations[0].stored_depth_from_world is not None
    recording = open_recording(tmp_path / 'out' / 'bag')
    frames = list(recording.depth_frames())
    stamps = np.array([frame.stamp_ns for frame in frames])
    np.testing.assert_array_equal(np.diff(stamps), round(1e9 / settings.timing.rate))
    first, stiff, again, loaded = (frames[2 * state].depth for state in range(4))
    body = np.isfinite(first) & (first < np.nanquantile(first, 0.05) + 0.1)

    def differing(one, other) -> int:
        """Count pixels that differ by more than noise, where the body is."""
        return int(np.count_nonzero(np.abs(one - other)[body] > 0.003))

    noise = differing(first, frames[1].depth)
    assert differing(first, again) < 2 * noise + 20
    assert differing(first, stiff) > 5 * noise + 100
    assert differing(first, loaded) > 5 * noise + 100
    # A load pulls the body down, away from where a stiffer one is; nothing else moves.
    assert differing(stiff, loaded) > differing(first, loaded)


def test_what_cannot_be_recorded_is_refused(tmp_path):
    scene = load_scene(write_beam_scene(tmp_path / 'true'))
    with pytest.raises(InputError, match='give at least one'):
        record_changes(scene, tmp_path / 'out', (), SETTINGS)
    with pytest.raises(InputError, match='give a factor above zero'):
        BodyState(-1.0)
    with pytest.raises(InputError, match='no negative payload'):
        BodyState(payload=-0.001)
    with pytest.raises(ValueError, match='only one read from a file'):
        record_changes(replace(scene, path=None), tmp_path / 'out', STATES, SETTINGS)
