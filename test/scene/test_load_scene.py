# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Scene files: what a sound one becomes."""

import math
from pathlib import Path
import shutil

from diffcal_ros.errors import SceneError
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.material import LameConvention
from diffcal_ros.rigid_transform import rotation_matrix
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.sections.marker_dictionaries import MARKER_COUNTS
import numpy as np
import pytest
from support.scene_files import BOARD

INF = float('inf')
EXAMPLE = Path(__file__).resolve().parents[2] / 'config' / 'example_scene.yaml'


def test_minimal_scene_gets_the_defaults(write_scene, beam_mesh):
    scene = load_scene(write_scene())
    assert scene.name == 'scene'
    assert scene.element is Element.QUADRATIC
    assert scene.convention is LameConvention.CONSISTENT
    assert scene.fit == ('youngs_modulus', 'rigid_offset')
    assert (scene.marker, scene.depth_camera, scene.color_camera) == (None, None, None)
    assert scene.notes == ()
    np.testing.assert_allclose(scene.mesh.rest_positions, beam_mesh.rest_positions, atol=1e-15)
    (region,) = scene.regions
    np.testing.assert_array_equal(region.tets, np.arange(beam_mesh.tet_count))
    quantity = region.youngs_modulus
    assert (quantity.start, quantity.lower, quantity.upper) == (6e4, 1e3, 1e8)
    assert quantity.prior_std is None


def test_example_scene_loads_and_uses_every_key(tmp_path, beam_mesh, write_tet):
    write_tet(tmp_path / 'beam.tet', beam_mesh)
    shutil.copy(EXAMPLE, tmp_path / 'scene.yaml')
    scene = load_scene(tmp_path / 'scene.yaml')
    hanging, twisted, dropped = scene.observations
    assert dropped.motion.release_time.upper == 0.3
    assert dropped.held[1].turn is None
    assert scene.regions[0].damping.start == 10.0
    assert [part.name for part in hanging.held] == ['clamp']
    assert [part.name for part in twisted.held] == ['clamp', 'far_end']
    assert twisted.held[1].turn.angle == pytest.approx(math.pi)
    assert hanging.bag == tmp_path / 'hanging' / 'bag'
    assert [region.name for region in scene.regions] == ['soft_half', 'stiff_half']
    assert scene.regions[0].youngs_modulus.prior_std == 3.0e4
    assert scene.marker.side == 0.02
    assert scene.depth_camera.fy == 462.0
    assert scene.masks.boxes == ((0, 0, 40, 479),)
    assert scene.masks.grazing_angle == pytest.approx(math.radians(75))
    assert scene.rigid_offset.rotation_std == pytest.approx(math.radians(5))
    np.testing.assert_allclose(np.ptp(scene.fixture.positions, axis=0), [0.03, 0.04, 0.04])


def test_a_board_takes_the_place_of_a_marker(write_scene):
    marker = load_scene(write_scene({'marker': BOARD})).marker
    assert (marker.dictionary, marker.id, marker.side) == ('DICT_4X4_50', 0, 0.022)
    assert (marker.board.columns, marker.board.rows) == (5, 7)
    assert (marker.board.square, marker.board.is_legacy) == (0.03, False)
    np.testing.assert_allclose(marker.size, [0.15, 0.21])
    later = {**BOARD, 'id': 12, 'board': {**BOARD['board'], 'rows': 6, 'legacy': True}}
    marker = load_scene(write_scene({'marker': later})).marker
    assert (marker.id, marker.board.is_legacy, marker.board.starts_white) == (12, True, True)


def test_regions_that_share_a_face_cover_the_body_once(write_scene, beam_mesh):
    body = {'youngs_modulus': '1e5', 'poissons_ratio': 0.49, 'density': 1080}
    # A tetrahedron's centroid on the shared face must go to exactly one of the two.
    face = float(beam_mesh.centroids[np.argsort(beam_mesh.centroids[:, 0])[60], 0])
    halves = {
        'low': {**body, 'box': {'x': [-INF, face]}},
        'high': {**body, 'box': {'x': [face, INF]}},
    }
    scene = load_scene(write_scene({'regions': halves}))
    together = np.concatenate([region.tets for region in scene.regions])
    np.testing.assert_array_equal(np.sort(together), np.arange(beam_mesh.tet_count))
    assert scene.regions[0].youngs_modulus.start == 1e5


def test_rest_takes_what_the_others_leave(write_scene):
    body = {'youngs_modulus': 1e5, 'poissons_ratio': 0.49, 'density': 1080}
    listed = {'some': {**body, 'tets': [5, 3]}, 'others': {**body, 'rest': True}}
    some, others = load_scene(write_scene({'regions': listed})).regions
    np.testing.assert_array_equal(some.tets, [3, 5])
    assert len(others.tets) == 190


def test_held_box_forgives_the_rounding_of_single_precision(write_scene):
    changes = {'held.clamp.box.x': [0.1 + 2e-8, 0.2]}
    assert len(load_scene(write_scene(changes)).observations[0].held[0].vertices) == 9
    with pytest.raises(SceneError, match='no vertex lies in it'):
        load_scene(write_scene({'held.clamp.box.x': [0.1 + 2e-6, 0.2]}))


def test_held_box_takes_vertices_on_its_face(write_scene, beam_mesh):
    scene = load_scene(write_scene({'held.clamp': {'box': {'x': [0.075, 0.1]}}}))
    held = scene.observations[0].held[0].vertices
    expected = np.flatnonzero(beam_mesh.rest_positions[:, 0] > 0.074)
    np.testing.assert_array_equal(held, expected)


@pytest.mark.parametrize(
    'rotation',
    [
        {'rotation_vector_deg': [0, 0, 90]},
        {'quaternion_xyzw': [0, 0, 0.70711, 0.70711]},
        {'rotation_matrix': [[0, -1, 0], [1, 0, 0], [0, 0, 1]]},
    ],
)
def test_the_three_rotations_mean_the_same(write_scene, rotation):
    path = write_scene({'placement': {'translation': [0.1, 0.2, 0.3], **rotation}})
    world_from_object = load_scene(path).observations[0].world_from_object
    expected = rotation_matrix(np.array([0.0, 0.0, np.pi / 2]))
    np.testing.assert_allclose(world_from_object[:3, :3], expected, atol=1e-12)
    np.testing.assert_allclose(world_from_object[:3, 3], [0.1, 0.2, 0.3])


def test_a_rounded_rotation_becomes_a_true_one(write_scene):
    rows = [[0.9945, 0, -0.1045], [0, -1, 0], [-0.1045, 0, -0.9945]]
    path = write_scene({'placement': {'translation': [0, 0, 0], 'rotation_matrix': rows}})
    rotation = load_scene(path).observations[0].world_from_object[:3, :3]
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(rotation, rows, atol=5e-5)


def test_observations_override_placement_gravity_pose_and_turns(write_scene):
    pose = {'translation': [0, 0, 0.4]}
    path = write_scene(
        {
            'stored_depth_from_world': pose,
            'held.far': {
                'box': {'x': [-INF, -0.08]},
                'turn': {'axis': [2, 0, 0], 'angle_deg': 400, 'translation': [0, 0, 0.01]},
            },
            'observations': [
                {'name': 'as_above'},
                {
                    'name': 'own',
                    'gravity': [0, 0, 9.8],
                    'placement': {'translation': [0, 0, 1]},
                    'stored_depth_from_world': {'translation': [0, 0, 2]},
                    'held_turns': {'far': None},
                },
                {'name': 'other', 'held_turns': {'far': {'axis': [0, 1, 0], 'angle_deg': 5}}},
            ],
        }
    )
    above, own, other = load_scene(path).observations
    np.testing.assert_allclose(above.held[1].turn.axis, [1, 0, 0])
    assert above.held[1].turn.angle == pytest.approx(math.radians(400))
    assert above.stored_depth_from_world[2, 3] == 0.4
    assert own.held[1].turn is None
    assert (own.gravity[2], own.world_from_object[2, 3]) == (9.8, 1.0)
    assert own.stored_depth_from_world[2, 3] == 2.0
    np.testing.assert_allclose(other.held[1].turn.axis, [0, 1, 0])


def test_marker_dictionaries_are_those_of_opencv():
    aruco = pytest.importorskip('cv2.aruco', reason='OpenCV is not installed')
    for name, count in MARKER_COUNTS.items():
        dictionary = aruco.getPredefinedDictionary(getattr(aruco, name))
        assert len(dictionary.bytesList) == count, name


def test_scene_of_the_twisted_capture_selects_what_the_data_say(diffcal_data, write_scene):
    """The data set's README counts 186 held vertices on the coarse cantilever."""
    file = diffcal_data / 'CAD_models' / 'cantilever_coarse' / 'cantilever_f640_v322.tet'
    changes = {'mesh': {'file': str(file), 'unit': 'cm'}, 'held.clamp.box.x': [0.07, INF]}
    scene = load_scene(write_scene(changes))
    assert len(scene.observations[0].held[0].vertices) == 186
