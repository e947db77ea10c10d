# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Synthetic recordings: what is written reads back as what was simulated."""

from dataclasses import replace
import json

from diffcal_ros.errors import InputError, RecordingError, SceneError
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.rigid_transform import angle_between, apply, inverse
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import PoseSetup
from diffcal_ros.synthetic.filming import Timing
from diffcal_ros.synthetic.lidar import LidarModel
from diffcal_ros.synthetic.posed_body import pose_body
from diffcal_ros.synthetic.recorder import record
from diffcal_ros.synthetic.viewpoint import DEPTH_FROM_COLOR
import numpy as np
import pytest
from support.recorded_beam import (
    COLOR_CAMERA,
    DEPTH_CAMERA,
    MODULUS,
    record_beam,
    SETTINGS,
    write_beam_scene,
)
import yaml


def truth_of(made) -> dict:
    return json.loads(made.truth.read_text())


def test_frames_cameras_and_stamps_read_back(recorded_beam):
    recording = open_recording(recorded_beam.bags['observation'])
    assert (recording.depth_count, recording.color_count) == (4, 2)
    assert recording.depth_camera == DEPTH_CAMERA
    assert recording.color_camera == COLOR_CAMERA
    np.testing.assert_allclose(recording.depth_from_color, DEPTH_FROM_COLOR, atol=1e-9)
    stamps = [frame.stamp_ns for frame in recording.depth_frames()]
    np.testing.assert_allclose(np.diff(stamps), 1e9 / 30.0, atol=1.0)
    assert recording.notes == ()


def test_the_bodys_depth_is_that_of_the_simulated_surface(recorded_beam):
    """Lift the pixels of the free end: their median distance to the nodes' plane is noise."""
    truth = truth_of(recorded_beam)
    pose = np.array(truth['observations']['observation']['depth_from_world'])
    scene = load_scene(recorded_beam.scene.parents[1] / 'true_scene.yaml')
    body = pose_body(scene, scene.observations[0])
    frame = next(iter(open_recording(recorded_beam.bags['observation']).depth_frames()))
    points = apply(inverse(pose), DEPTH_CAMERA.back_project(frame.depth.astype(float)))
    corners = body.positions[body.triangles]
    middle = corners.mean(axis=1)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    pixels = np.rint(DEPTH_CAMERA.project(apply(pose, middle))).astype(int)
    facing = np.einsum('fi,fi->f', normals, inverse(pose)[:3, 3] - middle) > 0.1
    free = facing & (body.rest[body.triangles].mean(axis=1)[:, 0] < -0.02)
    offsets = [
        normal @ (points[row, column] - center)
        for (column, row), center, normal in zip(
            pixels[free], middle[free], normals[free], strict=True
        )
    ]
    assert len(offsets) > 50
    assert abs(np.nanmedian(offsets)) < 0.1e-3
    assert np.nanmedian(np.abs(offsets)) < 0.2e-3


def test_the_marker_gives_the_true_camera_pose(recorded_beam):
    scene = load_scene(recorded_beam.scene)
    (observation,) = open_inputs(scene, []).observations
    true_pose = np.array(
        truth_of(recorded_beam)['observations']['observation']['depth_from_world']
    )
    marker_distance = np.linalg.norm(true_pose[:3, 3])
    error = observation.depth_from_world @ inverse(true_pose)
    assert np.linalg.norm(observation.depth_from_world[:3, 3] - true_pose[:3, 3]) < 1e-3
    assert angle_between(error, np.eye(4)) < np.deg2rad(1.0)
    assert 0.2 < marker_distance < 0.6


def test_the_clamp_hides_what_it_holds_and_a_wall_stands_behind(recorded_beam):
    pose = np.array(truth_of(recorded_beam)['observations']['observation']['depth_from_world'])
    scene = load_scene(recorded_beam.scene.parents[1] / 'true_scene.yaml')
    body = pose_body(scene, scene.observations[0])
    frame = next(iter(open_recording(recorded_beam.bags['observation']).depth_frames()))
    held = apply(pose, body.positions[body.held_nodes])
    columns, rows = np.rint(DEPTH_CAMERA.project(held)).astype(int).T
    in_front = held[:, 2] - frame.depth[rows, columns]
    assert 0.010 < np.nanmedian(in_front) < 0.060
    corners = frame.depth[[5, 5, -6, -6], [5, -6, 5, -6]]
    assert (corners > apply(pose, body.positions)[:, 2].max() + 0.05).all()


def test_the_scene_starts_off_the_truth_and_nothing_else_changes(recorded_beam):
    truth = truth_of(recorded_beam)
    assert truth['parameters']['body']['youngs_modulus'] == MODULUS
    written = yaml.safe_load(recorded_beam.scene.read_text())
    source = yaml.safe_load((recorded_beam.scene.parents[1] / 'true_scene.yaml').read_text())
    assert written['regions']['body']['youngs_modulus'] == pytest.approx(1.4 * MODULUS)
    assert written['regions']['body']['density'] == source['regions']['body']['density']
    assert written['bag'] == 'bag'
    assert 'stored_depth_from_world' not in written
    changed = {key for key in written if written[key] != source.get(key)}
    assert changed == {'regions', 'bag', 'sensor'}
    assert 'truth.json' in recorded_beam.scene.read_text()


def test_the_same_seed_gives_the_same_bytes_and_another_does_not(tmp_path):
    def bytes_of(folder: str, seed: int) -> bytes:
        made = record_beam(tmp_path / folder, seed=seed, frames=2, color_frames=1)
        return next(made.bags['observation'].glob('*.mcap')).read_bytes()

    first = bytes_of('a', 1)
    assert bytes_of('b', 1) == first
    assert bytes_of('c', 2) != first


def test_a_finer_truth_is_another_mesh_of_the_same_body(tmp_path, recorded_beam):
    made = record_beam(tmp_path, is_refined=True, frames=1, color_frames=1)
    coarse, fine = truth_of(recorded_beam), truth_of(made)
    assert fine['tet_count'] == 8 * coarse['tet_count']
    sags = [
        truth['observations']['observation']['largest_displacement'] for truth in (coarse, fine)
    ]
    assert sags[0] < sags[1] < 1.05 * sags[0]


def test_millimetre_images_are_announced_in_the_scene(tmp_path):
    made = record_beam(tmp_path, lidar=LidarModel(encoding='16UC1'), frames=1, color_frames=1)
    frame = next(iter(open_recording(made.bags['observation']).depth_frames()))
    millimetres = 1e3 * frame.depth[np.isfinite(frame.depth)].astype(float)
    np.testing.assert_allclose(millimetres, np.round(millimetres), atol=1e-3)
    sensor = load_scene(made.scene).sensor
    assert (sensor.quantization, sensor.quantization_mode) == (0.001, 'truncate')


def test_what_is_stored_is_exact_and_a_source_that_is_not_recorded_becomes_stored(tmp_path):
    section = {'source': 'tf', 'world_frame': 'rig_link', 'position_std': 0.002}
    made = record_beam(tmp_path, {'pose': section}, frames=1, color_frames=1)
    (setup,) = load_scene(made.scene).observations
    assert setup.stored_depth_from_world is not None
    assert setup.pose == PoseSetup('stored', position_std=0.0, rotation_std=0.0)
    (observation,) = open_inputs(load_scene(made.scene), []).observations
    assert observation.pose_covariance is None


def test_without_a_marker_the_pose_is_stored(tmp_path):
    made = record_beam(tmp_path, {'marker': ...}, frames=1, color_frames=1)
    assert made.notes == ('the scene has no marker: calibrate with --pose stored',)
    (setup,) = load_scene(made.scene).observations
    stored = setup.stored_depth_from_world
    true_pose = np.array(truth_of(made)['observations']['observation']['depth_from_world'])
    np.testing.assert_allclose(stored, true_pose, atol=1e-8)


def test_the_camera_stands_where_it_is_told(tmp_path):
    position = (-0.1, 0.05, 0.35)
    made = record_beam(tmp_path, camera_position=position, frames=1, color_frames=0)
    true_pose = np.array(truth_of(made)['observations']['observation']['depth_from_world'])
    np.testing.assert_allclose(inverse(true_pose)[:3, 3], position, atol=1e-9)
    assert open_recording(made.bags['observation']).color_count == 0


def test_a_stored_pose_is_used_and_kept(tmp_path, recorded_beam):
    pose = truth_of(recorded_beam)['observations']['observation']['depth_from_world']
    moved = np.array(pose)
    moved[2, 3] += 0.05
    placement = {
        'translation': moved[:3, 3].tolist(),
        'rotation_matrix': moved[:3, :3].tolist(),
    }
    made = record_beam(tmp_path, {'stored_depth_from_world': placement}, frames=1, color_frames=1)
    true_pose = np.array(truth_of(made)['observations']['observation']['depth_from_world'])
    np.testing.assert_allclose(true_pose, moved, atol=1e-9)
    stored = load_scene(made.scene).observations[0].stored_depth_from_world
    np.testing.assert_allclose(stored, moved, atol=1e-8)


def test_each_observation_has_a_bag_of_its_own(tmp_path):
    observations = [
        {'name': 'level'},
        {'name': 'upside_down', 'gravity': [0, 9.81, 0]},
    ]
    made = record_beam(tmp_path, {'observations': observations}, frames=1, color_frames=1)
    assert {name: bag.name for name, bag in made.bags.items()} == {
        'level': 'bag_level',
        'upside_down': 'bag_upside_down',
    }
    scene = load_scene(made.scene)
    assert [setup.bag.name for setup in scene.observations] == ['bag_level', 'bag_upside_down']
    assert len(open_inputs(scene, []).observations) == 2


def test_a_turned_clamp_turns_its_block_too(tmp_path):
    """A body twisted by a quarter turn is hidden at both ends."""
    both = {
        'held.far': {
            'box': {'x': [float('-inf'), 0.015]},
            'turn': {'axis': [1, 0, 0], 'angle_deg': 90},
        }
    }
    made = record_beam(tmp_path, both, frames=1, color_frames=1)
    pose = np.array(truth_of(made)['observations']['observation']['depth_from_world'])
    scene = load_scene(tmp_path / 'true_scene.yaml')
    body = pose_body(scene, scene.observations[0])
    frame = next(iter(open_recording(made.bags['observation']).depth_frames()))
    far = body.positions[body.held_nodes]
    far = apply(pose, far[far[:, 0] < -0.08])
    columns, rows = np.rint(DEPTH_CAMERA.project(far)).astype(int).T
    assert 0.010 < np.nanmedian(far[:, 2] - frame.depth[rows, columns]) < 0.060


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'color_frames': 9}, r'4 depth and 9 colour frames .*no more colour than depth'),
        ({'time_step': 1.0}, r'time step is 1 s: give 1e-6 to 0\.1'),
        ({'seed': -1}, r'seed is -1'),
        ({'start_factor': 0.0}, r'start factor is 0: give 0\.1 to 10'),
    ],
)
def test_settings_that_make_no_sense_are_refused(change, message):
    with pytest.raises(InputError, match=message):
        replace(SETTINGS, **change)


def test_a_recording_that_is_there_is_not_written_over(tmp_path):
    made = record_beam(tmp_path, frames=1, color_frames=1)
    before = made.scene.read_bytes()
    source = load_scene(tmp_path / 'true_scene.yaml')
    with pytest.raises(RecordingError, match=r'exists already: .* --overwrite'):
        record(source, made.scene.parent, SETTINGS)
    assert made.scene.read_bytes() == before
    again = replace(SETTINGS, start_factor=2.0, timing=Timing(1), color_frames=1)
    record(source, made.scene.parent, again, overwrite=True)
    assert made.scene.read_bytes() != before


def test_the_scene_that_is_simulated_is_never_written_over(tmp_path):
    path = write_beam_scene(tmp_path).rename(tmp_path / 'scene.yaml')
    before = path.read_bytes()
    with pytest.raises(RecordingError, match='is the scene to simulate: choose another folder'):
        record(load_scene(path), tmp_path, SETTINGS, overwrite=True)
    assert path.read_bytes() == before


def test_bounds_that_leave_no_room_for_the_start_are_told(tmp_path):
    tight = {'start': MODULUS, 'min': 0.9 * MODULUS, 'max': 1.1 * MODULUS}
    with pytest.raises(InputError, match=r'bounds of youngs_modulus\.body, 81000 to 99000'):
        record_beam(tmp_path, {'regions.body.youngs_modulus': tight})
    assert not (tmp_path / 'recorded').exists()


def test_the_start_goes_below_where_there_is_no_room_above(tmp_path):
    high = {'start': MODULUS, 'min': 1e4, 'max': 1.1 * MODULUS}
    made = record_beam(tmp_path, {'regions.body.youngs_modulus': high}, frames=1, color_frames=1)
    (region,) = load_scene(made.scene).regions
    assert region.youngs_modulus.start == pytest.approx(MODULUS / 1.4, rel=1e-5)


def test_a_camera_that_looks_away_is_told(tmp_path):
    away = {'translation': [0, 0, -0.4], 'rotation_vector_deg': [0, 0, 0]}
    with pytest.raises(SceneError, match='synthetic camera of observation does not see the body'):
        record_beam(tmp_path, {'stored_depth_from_world': away})
    assert not (tmp_path / 'recorded').exists()
