# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Mesh files: every format gives back the same body, and broken files say what is wrong."""

from diffcal_ros.errors import InputError
from diffcal_ros.scene.sections.mesh_files import read_mesh, UNITS_PER_METRE
from diffcal_ros.tet_mesh import mesh_problems, TET_EDGES, TetMesh
import meshio
import numpy as np
import pytest


def _write_meshio(path, mesh, cells=None, **options):
    blocks = [('tetra', mesh.tets)] if cells is None else cells
    meshio.Mesh(mesh.rest_positions, blocks).write(path, **options)
    return path


@pytest.mark.parametrize('unit', UNITS_PER_METRE)
def test_tet_file_round_trips_in_each_unit(tmp_path, beam_mesh, write_tet, unit):
    path = write_tet(tmp_path / 'beam.tet', beam_mesh, UNITS_PER_METRE[unit])
    read = read_mesh(path, unit=unit)
    np.testing.assert_allclose(read.mesh.rest_positions, beam_mesh.rest_positions, atol=1e-15)
    np.testing.assert_array_equal(read.mesh.tets, beam_mesh.tets)
    assert read.mesh.tets.dtype == np.int32
    assert read.notes == ()


def test_decimals_stay_as_written(tmp_path):
    """57 mm must become the double nearest to 0.057, or boxes at 0.057 miss the vertex."""
    lines = ['v 0 0 0', 'v 57 0 0', 'v 0 57 0', 'v 0 0 57', 't 0 1 2 3']
    (tmp_path / 'one.tet').write_text('\n'.join(lines))
    mesh = read_mesh(tmp_path / 'one.tet', unit='mm').mesh
    assert mesh.rest_positions[1, 0] == 0.057


def test_tet_file_may_have_blank_lines_comments_and_windows_ends(tmp_path):
    lines = ['# by hand', '', '  v  0 0 0', 'v 1 0 0 ', 'v\t0 1 0', 'v 0 0 1e0', ' t 0 1  2 3', '']
    (tmp_path / 'one.tet').write_bytes('\r\n'.join(lines).encode())
    mesh = read_mesh(tmp_path / 'one.tet', unit='m').mesh
    assert (mesh.vertex_count, mesh.tet_count) == (4, 1)
    assert mesh.volumes[0] == pytest.approx(1 / 6)


@pytest.mark.parametrize(
    ('line', 'sentence'),
    [
        ('v 1 2', "line 2 is 'v 1 2': three numbers are needed after v"),
        ('v 1 2 x', "line 2 is 'v 1 2 x': three numbers are needed after v"),
        ('t 0 1 2', "line 2 is 't 0 1 2': four whole numbers are needed after t"),
        ('t 0 1 2 3.5', "line 2 is 't 0 1 2 3.5': four whole numbers are needed after t"),
        ('f 1 2 3', "line 2 starts with 'f': a line is `v x y z` or `t a b c d`"),
    ],
)
def test_bad_lines_are_named(tmp_path, line, sentence):
    (tmp_path / 'bad.tet').write_text(f'v 0 0 0\n{line}\nv 1 0 0\nt 0 1 2 3\n')
    with pytest.raises(InputError, match=f'bad.tet, {sentence}'):
        read_mesh(tmp_path / 'bad.tet', unit='m')


@pytest.mark.parametrize(
    ('name', 'options'),
    [
        ('beam.msh', {'file_format': 'gmsh22', 'binary': False}),
        ('beam.msh', {'file_format': 'gmsh'}),
        ('beam.vtk', {'binary': True}),
        ('beam.vtk', {'binary': False}),
        ('beam.vtu', {}),
    ],
)
def test_volume_formats_give_the_same_body(tmp_path, beam_mesh, name, options):
    path = _write_meshio(tmp_path / name, beam_mesh, **options)
    mesh = read_mesh(path, unit='m').mesh
    np.testing.assert_allclose(mesh.rest_positions, beam_mesh.rest_positions, atol=1e-12)
    np.testing.assert_array_equal(mesh.tets, beam_mesh.tets)


def test_ten_node_tetrahedra_lose_their_middle_nodes(tmp_path, beam_mesh):
    edges, sides = beam_mesh.edges
    middles = beam_mesh.rest_positions[edges].mean(axis=1)
    # Middle nodes first, so that corners have to be numbered anew.
    nodes = np.vstack([middles, beam_mesh.rest_positions])
    tets = np.hstack([beam_mesh.tets + len(middles), sides])
    surface = beam_mesh.surface_triangles + len(middles)
    assert TET_EDGES.shape == (6, 2)
    cells = [('triangle', surface), ('tetra10', tets)]
    meshio.Mesh(nodes, cells).write(tmp_path / 'beam.vtu')
    mesh = read_mesh(tmp_path / 'beam.vtu', unit='m').mesh
    np.testing.assert_allclose(mesh.rest_positions, beam_mesh.rest_positions)
    np.testing.assert_array_equal(mesh.tets, beam_mesh.tets)
    assert mesh_problems(mesh) == []


def test_a_mesh_listed_the_other_way_round_is_turned_with_a_note(tmp_path, beam_mesh, write_tet):
    mirrored = TetMesh(beam_mesh.rest_positions, beam_mesh.tets[:, [1, 0, 2, 3]])
    read = read_mesh(write_tet(tmp_path / 'beam.tet', mirrored), unit='mm')
    assert (read.mesh.volumes > 0).all()
    assert mesh_problems(read.mesh) == []
    assert 'all 192 tetrahedra of beam.tet are listed the other way round' in read.notes[0]


def test_a_mesh_of_mixed_orientation_is_left_for_the_check(tmp_path, beam_mesh, write_tet):
    tets = beam_mesh.tets.copy()
    tets[7] = tets[7][[1, 0, 2, 3]]
    mixed = TetMesh(beam_mesh.rest_positions, tets)
    read = read_mesh(write_tet(tmp_path / 'beam.tet', mixed), unit='mm')
    assert read.notes == ()
    (problem,) = mesh_problems(read.mesh)
    assert problem.startswith('1 of 192 tetrahedra are inverted (negative volume, first: 7)')


@pytest.mark.parametrize(
    ('spoil', 'sentence'),
    [
        (lambda v, t: (np.vstack([v, [[0, 0, 0.5]]]), t), '1 vertices belong to no tetrahedron'),
        (lambda v, t: (v, np.vstack([t, t[:2, [1, 2, 0, 3]]])), '2 tetrahedra are duplicates'),
        (lambda v, t: (v, t + 1), r'name vertex 81, but there are only 0 to 80: .*0-based'),
        (
            lambda v, t: (v, t + np.int64(2**32)),
            r'name vertex 2147483647, but there are',
        ),
        (lambda v, t: (v, t - 1), r'name vertex -1, but there are only 0 to 80'),
        (lambda v, t: (np.where(v == v[3, 0], np.nan, v), t), 'vertex positions hold NaN or Inf'),
        (lambda v, t: (v, t[:0]), 'the mesh has no tetrahedra'),
    ],
)
def test_unsound_meshes_are_refused(tmp_path, beam_mesh, write_tet, spoil, sentence):
    spoilt = TetMesh(*spoil(beam_mesh.rest_positions, beam_mesh.tets))
    mesh = read_mesh(write_tet(tmp_path / 'beam.tet', spoilt), unit='mm').mesh
    with pytest.raises(AssertionError, match=sentence):
        raise AssertionError('; '.join(mesh_problems(mesh)))


def test_cells_that_are_no_tetrahedra_are_refused(tmp_path, beam_mesh):
    box = np.arange(8)[None]
    hexahedra = _write_meshio(tmp_path / 'hex.vtk', beam_mesh, [('hexahedron', box)])
    with pytest.raises(InputError, match=r'hex\.vtk holds hexahedron cells: only tetrahedra'):
        read_mesh(hexahedra, unit='m')
    faces = [('triangle', beam_mesh.surface_triangles)]
    surface = _write_meshio(tmp_path / 'faces.vtk', beam_mesh, faces)
    with pytest.raises(InputError, match=r'holds no tetrahedra: give a volume mesh, or its surf'):
        read_mesh(surface, unit='m')


@pytest.mark.parametrize('suffix', ['.msh', '.vtk', '.vtu'])
@pytest.mark.parametrize('content', [b'', b'nonsense\n', b'\x00\xff\xfe\x01' * 50])
def test_broken_files_say_so_and_do_not_end_the_program(tmp_path, suffix, content):
    path = tmp_path / f'broken{suffix}'
    path.write_bytes(content)
    with pytest.raises(InputError, match=rf'broken{suffix} (cannot be read as|holds no tetra)'):
        read_mesh(path, unit='m')


def test_a_cut_off_file_says_so(tmp_path, beam_mesh):
    path = _write_meshio(tmp_path / 'beam.vtu', beam_mesh)
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(InputError, match=r'beam\.vtu cannot be read as \.vtu'):
        read_mesh(path, unit='m')


def test_a_binary_tet_file_is_refused(tmp_path):
    (tmp_path / 'x.tet').write_bytes(b'\xff\xfe\x00v')
    with pytest.raises(InputError, match=r'x\.tet cannot be read as text'):
        read_mesh(tmp_path / 'x.tet', unit='m')


def test_every_mesh_of_the_public_data_is_sound(diffcal_data):
    files = sorted((diffcal_data / 'CAD_models').glob('*/*.tet'))
    assert files
    for file in files:
        read = read_mesh(file, unit='cm')
        assert mesh_problems(read.mesh) == [], file.name
        assert read.notes == ()
