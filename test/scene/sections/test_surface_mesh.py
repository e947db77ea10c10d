# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Surfaces: cut into tetrahedra once, the same ever after, and refused when they leak."""

import sys

from diffcal_ros.errors import InputError
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.sections.mesh_files import read_mesh
from diffcal_ros.tet_mesh import mesh_problems
import numpy as np
import pytest
import trimesh

# Cutting keeps to the surface within a thousandth of the diagonal.
_VOLUME_TOLERANCE = 0.01


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    return tmp_path / 'cache'


@pytest.fixture
def box_file(tmp_path):
    """A box of 60 x 30 x 30 mm, in millimetres."""
    path = tmp_path / 'box.stl'
    trimesh.creation.box(extents=(60.0, 30.0, 30.0)).export(path)
    return path


@pytest.mark.parametrize('suffix', ['.stl', '.obj', '.ply'])
def test_a_watertight_surface_becomes_a_sound_mesh(tmp_path, suffix):
    pytest.importorskip('pytetwild', reason='the extra `mesh` is not installed')
    path = tmp_path / f'box{suffix}'
    trimesh.creation.box(extents=(60.0, 30.0, 30.0)).export(path)
    read = read_mesh(path, unit='mm', edge_length=0.015)
    assert mesh_problems(read.mesh) == []
    assert read.mesh.volumes.sum() == pytest.approx(54e-6, rel=_VOLUME_TOLERANCE)
    assert f'the surface box{suffix} was cut into {read.mesh.tet_count} tetra' in read.notes[0]


def test_edge_length_is_in_metres_and_sets_the_size(box_file):
    pytest.importorskip('pytetwild', reason='the extra `mesh` is not installed')
    for edge_length in (0.006, 0.0036):
        mesh = read_mesh(box_file, unit='mm', edge_length=edge_length).mesh
        edges, _ = mesh.edges
        lengths = np.linalg.norm(np.diff(mesh.rest_positions[edges], axis=1), axis=-1)
        # The cutter aims at the length as a mean; here it comes within a fifth.
        assert np.median(lengths) == pytest.approx(edge_length, rel=0.25)


def test_the_second_reading_gives_the_same_mesh_without_cutting(box_file, own_cache, monkeypatch):
    pytest.importorskip('pytetwild', reason='the extra `mesh` is not installed')
    first = read_mesh(box_file, unit='mm', edge_length=0.015)
    monkeypatch.setitem(sys.modules, 'pytetwild', None)
    second = read_mesh(box_file, unit='mm', edge_length=0.015)
    np.testing.assert_array_equal(first.mesh.rest_positions, second.mesh.rest_positions)
    np.testing.assert_array_equal(first.mesh.tets, second.mesh.tets)
    assert 'taken from' in second.notes[0]
    assert len(list((own_cache / 'diffcal' / 'meshes').iterdir())) == 1


def test_a_spoilt_kept_mesh_is_cut_anew(box_file, own_cache):
    pytest.importorskip('pytetwild', reason='the extra `mesh` is not installed')
    read_mesh(box_file, unit='mm', edge_length=0.03)
    (kept,) = (own_cache / 'diffcal' / 'meshes').iterdir()
    kept.write_bytes(kept.read_bytes()[:100])
    assert 'kept as' in read_mesh(box_file, unit='mm', edge_length=0.03).notes[0]


def test_without_the_extra_the_message_says_what_to_install(box_file, monkeypatch):
    monkeypatch.setitem(sys.modules, 'pytetwild', None)
    with pytest.raises(InputError, match=r'needs the extra `mesh` .*`pip install pytetwild pyvis'):
        read_mesh(box_file, unit='mm')


def test_a_leaking_surface_is_refused(tmp_path):
    box = trimesh.creation.box(extents=(60.0, 30.0, 30.0))
    open_box = trimesh.Trimesh(box.vertices, box.faces[1:])
    open_box.export(tmp_path / 'open.stl')
    with pytest.raises(InputError, match=r'open\.stl is not watertight \(3 edges .* close its'):
        read_mesh(tmp_path / 'open.stl', unit='mm')


def test_triangles_that_face_both_ways_are_refused(tmp_path):
    box = trimesh.creation.box(extents=(60.0, 30.0, 30.0))
    faces = box.faces.copy()
    faces[0] = faces[0][::-1]
    trimesh.Trimesh(box.vertices, faces, process=False).export(tmp_path / 'mixed.ply')
    with pytest.raises(InputError, match=r'mixed\.ply has triangles that face both ways'):
        read_mesh(tmp_path / 'mixed.ply', unit='mm')


@pytest.mark.parametrize('content', [b'', b'solid nothing\nendsolid\n', b'\x00' * 40])
def test_broken_surfaces_say_so(tmp_path, content):
    (tmp_path / 'broken.stl').write_bytes(content)
    with pytest.raises(InputError, match=r'broken.stl (cannot be read as|holds no triangles)'):
        read_mesh(tmp_path / 'broken.stl', unit='mm')


@pytest.mark.parametrize('edge_length', [15.0, 1e-6])
def test_an_edge_length_in_another_unit_is_refused(box_file, edge_length):
    pytest.importorskip('pytetwild', reason='the extra `mesh` is not installed')
    with pytest.raises(InputError, match=r'edge_length is .* of the size of box\.stl: give it in'):
        read_mesh(box_file, unit='mm', edge_length=edge_length)


def test_a_scene_may_name_a_surface(write_scene, box_file):
    pytest.importorskip('pytetwild', reason='the extra `mesh` is not installed')
    changes = {
        'mesh': {'file': 'box.stl', 'unit': 'mm', 'edge_length': 0.015},
        'held.clamp.box.x': [0.025, float('inf')],
    }
    scene = load_scene(write_scene(changes))
    assert scene.mesh.extent[1] == pytest.approx([0.03, 0.015, 0.015], abs=1e-4)
    assert len(scene.notes) == 1
