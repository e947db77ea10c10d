# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Meshes, depth and film of a prediction, read back by other programs' eyes."""

import json
import xml.etree.ElementTree as ET

from diffcal_ros.prediction.depth_files import write_depth_bag, write_depth_files
from diffcal_ros.prediction.mesh_sequence import COLLECTION, write_meshes
from diffcal_ros.prediction.predicted_view import look_at
from diffcal_ros.recording.bag_reader import open_recording
import meshio
import numpy as np
import pytest
import trimesh

EXACT = 1e-9  # What nine digits lose of a metre.


@pytest.fixture(scope='session')
def view(moving_scene, moving_body):
    (only,) = look_at(moving_scene, [moving_body])
    return only


def test_volumes_have_their_nodes_and_times(moving_body, tmp_path):
    opened = write_meshes(moving_body, tmp_path, 'vtu')
    assert opened == tmp_path / COLLECTION
    sets = list(ET.parse(opened).getroot().iter('DataSet'))
    assert [float(row.get('timestep')) for row in sets] == pytest.approx(moving_body.times)
    for row, positions in zip(sets, moving_body.positions, strict=True):
        mesh = meshio.read(tmp_path / row.get('file'))
        np.testing.assert_array_equal(mesh.points, positions)
        moved = positions - moving_body.discretisation.rest_nodes
        np.testing.assert_array_equal(mesh.point_data['displacement'], moved)
    (cells,) = mesh.cells
    assert cells.type == 'tetra10'
    # A mid-edge node lies between the corners that VTK's numbering gives it.
    corners = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
    rest = moving_body.discretisation.rest_nodes[cells.data]
    for place, (a, b) in enumerate(corners):
        np.testing.assert_allclose(rest[:, 4 + place], rest[:, [a, b]].mean(axis=1), atol=EXACT)


def test_surfaces_are_closed_and_outward(moving_body, tmp_path):
    assert write_meshes(moving_body, tmp_path, 'obj') == tmp_path
    files = sorted(tmp_path.glob('*.obj'))
    assert len(files) == len(moving_body.times)
    surface = trimesh.load(files[-1], process=False)
    assert surface.is_watertight
    assert surface.volume == pytest.approx(0.12 * 0.024 * 0.02, rel=0.02)
    used = np.unique(moving_body.discretisation.surface_triangles)
    np.testing.assert_allclose(surface.vertices, moving_body.positions[-1][used], atol=EXACT)


def test_nothing_is_written_where_no_mesh_is_wanted(moving_body, tmp_path):
    assert write_meshes(moving_body, tmp_path / 'mesh', 'none') is None
    assert not (tmp_path / 'mesh').exists()


def test_depth_files_and_bag_hold_the_same(view, tmp_path):
    write_depth_files(view, tmp_path / 'depth')
    write_depth_bag(view, tmp_path / 'bag', overwrite=False)
    about = json.loads((tmp_path / 'depth' / 'camera.json').read_text())
    recording = open_recording(tmp_path / 'bag')
    np.testing.assert_allclose(about['K'], recording.depth_camera.K)
    frames = list(recording.depth_frames())
    times = [1e-9 * (frame.stamp_ns - frames[0].stamp_ns) for frame in frames]
    assert about['times'] == pytest.approx(times)
    for number, (frame, rendered) in enumerate(zip(frames, view.depths(), strict=True)):
        stored = np.load(tmp_path / 'depth' / f'{number:04d}.npz')
        assert float(stored['time']) == about['times'][number]
        np.testing.assert_array_equal(stored['depth'], rendered)
        np.testing.assert_array_equal(frame.depth, rendered)
