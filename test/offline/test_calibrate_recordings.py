# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Recordings to results in process: pairing, notes, the state kept after every step."""

from dataclasses import replace
import json
import shutil

from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import PoseError, RecordingError, SceneError
from diffcal_ros.offline.calibrate_recordings import open_inputs, run_calibration
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest

SETTINGS = CalibrationSettings(with_mesh_error=False)


@pytest.fixture(scope='module')
def scene(recorded_beam):
    return load_scene(recorded_beam.scene)


@pytest.fixture(scope='module')
def inputs(scene):
    return open_inputs(scene, [])


def with_postures(scene, *names):
    (setup,) = scene.observations
    return replace(scene, observations=tuple(replace(setup, name=name) for name in names))


def test_the_scenes_bags_are_used_when_none_is_given(inputs, recorded_beam):
    (recording,) = inputs.recordings
    assert recording.path == recorded_beam.bags['observation']
    (observation,) = inputs.observations
    assert observation.frame_count == 4
    assert observation.noise < 0.001
    assert inputs.notes == ('recorded: pose of the marker from 2 colour frames',)


def test_the_pose_is_that_of_the_truth(inputs, recorded_beam):
    truth = json.loads(recorded_beam.truth.read_text())['observations']['observation']
    found = inputs.observations[0].depth_from_world
    np.testing.assert_allclose(found, truth['depth_from_world'], atol=0.01)


def test_one_posture_takes_any_number_of_bags(scene, recorded_beam, tmp_path):
    bag = recorded_beam.bags['observation']
    again = shutil.copytree(bag, tmp_path / 'again')
    opened = open_inputs(scene, [bag, again])
    assert [o.setup_index for o in opened.observations] == [0, 0]
    assert [o.name for o in opened.observations] == ['recorded', 'again']


def test_several_postures_take_one_bag_each_in_order(scene, recorded_beam):
    bag = recorded_beam.bags['observation']
    two = with_postures(scene, 'low', 'high')
    opened = open_inputs(two, [bag, bag])
    assert [(o.name, o.setup_index) for o in opened.observations] == [('low', 0), ('high', 1)]
    with pytest.raises(SceneError, match=r'1 bags were given for the 2 .*\(low, high\): give one'):
        open_inputs(two, [bag])


def test_bags_that_the_scene_names_are_paired_by_their_names(scene, recorded_beam, tmp_path):
    bag = recorded_beam.bags['observation']
    other, third = (shutil.copytree(bag, tmp_path / name) for name in ('a', 'third'))
    two = with_postures(scene, 'low', 'high')
    two = replace(two, observations=(two.observations[0], replace(two.observations[1], bag=other)))
    shown = [(0, bag.resolve()), (1, other.resolve())]
    for given in ([bag, other], [other, bag], [tmp_path / 'third' / '..' / 'a', bag]):
        opened = open_inputs(two, given)
        paired = [
            (o.setup_index, r.path.resolve())
            for o, r in zip(opened.observations, opened.recordings, strict=True)
        ]
        assert paired == shown
    # Of other recordings only the order tells.
    assert [o.setup_index for o in open_inputs(two, [bag, third]).observations] == [0, 1]
    with pytest.raises(
        SceneError, match=r"a was given for .* 'low', but the scene says .* 'high'"
    ):
        open_inputs(two, [other, third])


def test_without_any_bag_there_is_nothing_to_fit(scene):
    (setup,) = scene.observations
    bare = replace(scene, observations=(replace(setup, bag=None),))
    with pytest.raises(SceneError, match='no bag was given and the scene does not name one'):
        open_inputs(bare, [])


def test_the_recording_at_fault_is_named(scene, recorded_beam, tmp_path):
    marker = replace(scene.marker, id=3)
    bag = recorded_beam.bags['observation']
    with pytest.raises(PoseError, match=r'recorded/bag: marker 3 .* but marker 7 of that'):
        open_inputs(replace(scene, marker=marker), [bag])
    # Once is enough where the message names it anyway.
    with pytest.raises(RecordingError) as error:
        open_inputs(scene, [tmp_path / 'none'])
    assert str(error.value).count('none') == 1


def test_the_scenes_camera_must_fit_the_images(scene, inputs):
    camera = replace(inputs.recordings[0].depth_camera, width=640)
    with pytest.raises(
        RecordingError, match=r'camera is for 640x300 pixels, but .* has 400x300: correct it'
    ):
        open_inputs(replace(scene, depth_camera=camera), [])


def test_an_unknown_pose_is_refused(scene):
    with pytest.raises(PoseError, match="has no 'stored_depth_from_world': add it"):
        open_inputs(scene, [], pose_source='stored')


@pytest.mark.slow
def test_the_same_recording_gives_the_same_numbers(scene, inputs, tmp_path):
    results = [
        run_calibration(open_inputs(scene, []), SETTINGS, tmp_path / name)[1]
        for name in ('one', 'two')
    ]
    assert results[0].values() == results[1].values()
    assert results[0].gap_end == results[1].gap_end


def test_after_every_step_the_file_is_whole(inputs, tmp_path):
    seen = []

    def look(record):
        kept = json.loads((tmp_path / 'result.json').read_text())
        assert kept['outcome'] == 'interrupted'
        assert kept['iterations'] == record.number
        value = kept['parameters']['youngs_modulus']['value']
        assert value == record.values['youngs_modulus']
        assert kept['gap']['end'] == pytest.approx(record.gap.as_dict())
        assert kept['recordings'][0]['sha256'] == inputs.recordings[0].sha256
        seen.append(record.number)
        return record.number < 2

    _, result = run_calibration(inputs, SETTINGS, tmp_path, on_iteration=look)
    assert seen == [0, 1, 2]
    assert result.outcome.value == 'interrupted'
    assert [path.name for path in tmp_path.iterdir()] == ['result.json']
