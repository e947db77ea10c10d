# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The importer on a small data set of our own making, in the public one's layout."""

import argparse

from diffcal_ros.cli.command_list import import_case as import_command
from diffcal_ros.cli.main import EXIT_DONE
from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.dataset.experiments import open_case
from diffcal_ros.recording.dataset.frames import load_depth
from diffcal_ros.recording.dataset.import_case import import_case
from diffcal_ros.rigid_transform import rotation_matrix, transform
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
import yaml

ALL = '-inf, inf, -inf, inf, -inf, inf'
CLAMP = '2.0, inf, -inf, inf, -inf, inf'
FAR = '-inf, -2.0, -inf, inf, -inf, inf'
STAMPS = ['1628838841.9277534', '1628838842.5', '1628838843.0573864']
DEPTH_FROM_COLOR = transform(
    rotation_matrix(np.array([0.03, -0.002, 0.014])), np.array([0.001, -0.014, 0.002])
)
COLOR_FROM_MARKER = transform(
    rotation_matrix(np.array([2.5, 0.3, -0.2])), np.array([0.03, -0.06, 0.47])
)


def settings(*, held=CLAMP, regions=ALL, rotation=None, **changes):
    """Write an experiment's settings; translation (-1, -2, 3) cm."""
    placement = transform(np.eye(3) if rotation is None else rotation, np.array([-1.0, -2.0, 3.0]))
    values = {
        'camera_data_path': 'somewhere/stale',
        'camera_intrinsics': [739.0, 0.0, 550.5, 0.0, 741.0, 390.5, 0.0, 0.0, 1.0],
        'camera_distortion': [0.0] * 14,
        'rgb_to_depth_transform': DEPTH_FROM_COLOR.T.ravel().tolist(),
        'camera_transform': np.eye(4).ravel().tolist(),
        'object_data_path': 'CAD_models/bar',
        'object_transform': placement.ravel().tolist(),
        'object_dirichlet_boundary_conditions': f'[{held}]',
        'object_parameter_bounding_boxes': f'[{regions}]',
    }
    values.update(changes)
    lines = [f'{key}={value}' for key, value in values.items() if value is not None]
    return '\n'.join(['EXPERIMENT SETTINGS', *lines, ''])


@pytest.fixture
def dataset(tmp_path):
    """A bar of 6 x 1 x 1 cm, its middle at (10, 0.5, 0.5) cm, without any experiment."""
    folder = tmp_path / 'dataset' / 'CAD_models' / 'bar'
    folder.mkdir(parents=True)
    corners = [(x, y, z) for x in range(7, 14) for y in (0, 1) for z in (0, 1)]
    lines = [f'v {x}.0 {y}.0 {z}.0' for x, y, z in corners]
    # Six tetrahedra around the diagonal of each cube.
    for cube in range(6):
        at = 4 * cube
        ring = [1, 5, 4, 6, 2, 3]
        for first, second in zip(ring, [*ring[1:], ring[0]], strict=True):
            lines.append(f't {at} {at + first} {at + second} {at + 7}')
    (folder / 'bar.tet').write_text('\n'.join(lines) + '\n')
    (tmp_path / 'dataset' / 'exp_data').mkdir()
    return tmp_path / 'dataset'


@pytest.fixture
def add_case(dataset, random):
    """Add an experiment with frames of the real sizes."""

    def add(folder, text, *, depth=(), color=(), poses=(), sub='', file=None):
        place = dataset / 'exp_data' / folder
        frames = place / 'camera_data' / sub
        frames.mkdir(parents=True)
        (place / f'{file or folder.replace(" ", "")}.exp').write_text(text)
        for stamp in depth:
            image = np.zeros((768, 1024), np.float32)
            image[100:200, 300:500] = 0.4 + 0.00025 * random.integers(0, 9, (100, 200))
            np.save(frames / f'd_{stamp}.npy', image)
        for stamp in color:
            np.save(frames / f'c_{stamp}.npy', np.full((720, 1280, 3), 7, np.uint8))
        for number, stamp in enumerate(poses):
            pose = COLOR_FROM_MARKER.copy()
            pose[0, 3] += 0.001 * number
            np.save(frames / f'v_0_{stamp}.npy', pose)

    return add


def test_all_depth_frames_are_written_with_their_stamps(dataset, add_case, tmp_path):
    add_case('h_e_c', settings(), depth=STAMPS[:2], color=STAMPS[1:], poses=STAMPS)
    imported = import_case(dataset, 'h_e_c', tmp_path / 'out')
    assert imported.warnings == ()
    assert (imported.bags['hanging'].depth_count, imported.bags['hanging'].color_count) == (2, 2)
    recording = open_recording(tmp_path / 'out' / 'bag')
    frames = list(recording.depth_frames())
    assert [frame.stamp_ns for frame in frames] == [1628838841_927753400, 1628838842_500000000]
    file = dataset / 'exp_data/h_e_c/camera_data' / f'd_{STAMPS[0]}.npy'
    stored = np.load(file)
    # Other readers of the bag see NaN too, not zero.
    assert np.isnan(load_depth(file, 0, recording.depth_camera).depth[stored == 0.0]).all()
    np.testing.assert_array_equal(frames[0].depth, np.where(stored > 0, stored, np.nan))
    np.testing.assert_allclose(recording.depth_from_color, DEPTH_FROM_COLOR, atol=1e-9)
    camera = recording.depth_camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (739.0, 741.0, 550.5, 390.5)
    assert next(recording.color_frames()).stamp_ns == 1628838842_500000000


def test_scene_stands_on_its_own(dataset, add_case, tmp_path):
    add_case('h_m_c', settings(), depth=STAMPS[1:2], poses=STAMPS)
    import_case(dataset, 'h_m_c', tmp_path / 'out')
    (tmp_path / 'out').rename(tmp_path / 'moved')
    dataset.rename(tmp_path / 'gone')
    scene = load_scene(tmp_path / 'moved' / 'scene.yaml')
    (setup,) = scene.observations
    assert open_recording(setup.bag).depth_count == 1
    # Boxes count from the middle of the body, x = 10 cm: the last nodes are held.
    held = scene.mesh.rest_positions[setup.held[0].vertices]
    np.testing.assert_allclose(np.unique(held[:, 0]), [0.12, 0.13])
    assert [region.name for region in scene.regions] == ['moldstar_15']
    np.testing.assert_allclose(setup.world_from_object[:3, :3], np.diag([1.0, -1.0, -1.0]))
    np.testing.assert_allclose(setup.world_from_object[:3, 3], [-0.01, -0.02, 0.03])
    # The pose of the depth frame's own stamp, the second one.
    expected = COLOR_FROM_MARKER.copy()
    expected[0, 3] += 0.001
    np.testing.assert_allclose(
        setup.stored_depth_from_world, DEPTH_FROM_COLOR @ expected, atol=1e-8
    )
    assert setup.pose.spread == pytest.approx((0.002, np.deg2rad(0.5)))
    assert setup.pose.is_spread_stated


def test_quaternion_is_read_in_the_simulators_order(dataset, add_case):
    # (w, x, y, z) = (c, 0, s, 0) becomes (x, y, z, w): half a turn about (c, 0, s).
    half = np.deg2rad(10.0)
    add_case('h_e_c', settings(rotation=rotation_matrix(np.array([0.0, 2.0 * half, 0.0]))))
    (setup,) = open_case(dataset, 'h_e_c').observations
    axis = np.array([np.cos(half), 0.0, np.sin(half)])
    np.testing.assert_allclose(
        setup.world_from_object[:3, :3], rotation_matrix(np.pi * axis), atol=1e-12
    )
    assert setup.notes == ()


@pytest.mark.parametrize(
    ('turn', 'expected'),
    [
        # Read in the simulator's order the clamp at +x goes to -x, away from the marker.
        ([np.pi, 0.0, 0.0], np.eye(3)),
        ([-np.pi / 2, 0.0, 0.0], np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])),
    ],
)
def test_clamp_decides_between_two_readings(dataset, add_case, turn, expected):
    rotation = rotation_matrix(np.array(turn))
    placement = transform(rotation, np.array([-12.5, 0.0, 0.0])).ravel().tolist()
    add_case('h_e_d', settings(object_transform=placement))
    (setup,) = open_case(dataset, 'h_e_d').observations
    np.testing.assert_allclose(setup.world_from_object[:3, :3], expected, atol=1e-12)
    assert 'can be read in two ways' in setup.notes[0]


def test_two_materials_are_read_from_the_clamp_outwards(dataset, add_case, tmp_path):
    halves = '-inf, 0, -inf, inf, -inf, inf, 0, inf, -inf, inf, -inf, inf'
    add_case('h_em_c', settings(regions=halves))
    import_case(dataset, 'h_em_c', tmp_path / 'out')
    scene = load_scene(tmp_path / 'out' / 'scene.yaml')
    centroids = {region.name: scene.mesh.centroids[region.tets, 0] for region in scene.regions}
    assert centroids['moldstar_15'].max() < 0.10 < centroids['ecoflex_50'].min()
    assert sum(len(region.tets) for region in scene.regions) == scene.mesh.tet_count


def test_material_in_two_places_is_one_region(dataset, add_case, tmp_path):
    thirds = (
        '-inf, -1, -inf, inf, -inf, inf, -1, 1, -inf, inf, -inf, inf, 1, inf, -inf, inf, -inf, inf'
    )
    add_case('t_mem_ c', settings(regions=thirds, held=f'{CLAMP}, {FAR}'))
    imported = import_case(dataset, 't_mem_c', tmp_path / 'out')
    scene = load_scene(imported.scene)
    names = {region.name: region for region in scene.regions}
    assert set(names) == {'moldstar_15', 'ecoflex_50'}
    inner = scene.mesh.centroids[names['ecoflex_50'].tets, 0]
    assert 0.09 <= inner.min() <= inner.max() <= 0.11
    clamp, far = scene.observations[0].held
    assert clamp.turn is None
    assert far.turn.angle == pytest.approx(-np.pi)
    np.testing.assert_allclose(far.turn.axis, [1.0, 0.0, 0.0])
    assert far.turn.center is None
    np.testing.assert_allclose(np.unique(scene.mesh.rest_positions[far.vertices, 0]), [0.07, 0.08])


def test_one_modulus_per_tetrahedron_starts_as_one_region(dataset, add_case, tmp_path):
    add_case('h_em_c_tetwise', settings())
    import_case(dataset, 'h_em_c_tetwise', tmp_path / 'out')
    (region,) = load_scene(tmp_path / 'out' / 'scene.yaml').regions
    assert region.name == 'body'


def test_joint_experiment_has_two_observations(dataset, add_case, tmp_path):
    hanging, twisting = 'h_em_c_tetwise', 't_em_c_tetwise'
    folder = 'ht_em_c_tetwise'
    add_case(folder, settings(), depth=STAMPS[:1], sub='hanging', file=hanging)
    place = dataset / 'exp_data' / folder
    (place / f'{twisting}.exp').write_text(settings(held=f'{CLAMP}, {FAR}'))
    frames = place / 'camera_data' / 'twisting'
    frames.mkdir()
    np.save(frames / f'd_{STAMPS[1]}.npy', np.full((768, 1024), 0.4, np.float32))
    imported = import_case(dataset, folder, tmp_path / 'out')
    scene = load_scene(imported.scene)
    first, second = scene.observations
    assert (first.name, second.name) == ('hanging', 'twisting')
    assert [part.name for part in first.held] == ['clamp']
    assert [part.name for part in second.held] == ['clamp', 'far_block']
    assert second.held[1].turn.angle == pytest.approx(-np.pi)
    assert open_recording(first.bag).first_stamp_ns < open_recording(second.bag).first_stamp_ns


def test_case_without_frames_gives_the_scene_and_says_so(dataset, add_case, tmp_path, capsys):
    add_case('h_e_d', settings())
    arguments = parse(['import', str(dataset), 'h_e_d', '--out', str(tmp_path / 'out')])
    assert arguments.run(arguments) == EXIT_DONE
    said = capsys.readouterr()
    assert 'scene.yaml' in said.out
    assert 'has no depth frame' in said.err
    assert 'no bag was written' in said.err
    assert sorted(path.name for path in (tmp_path / 'out').iterdir()) == ['bar.tet', 'scene.yaml']
    scene = load_scene(tmp_path / 'out' / 'scene.yaml')
    assert scene.observations[0].bag is None
    assert (scene.depth_camera.width, scene.depth_camera.fx) == (1024, 739.0)


def test_case_with_colour_only_gives_a_bag_of_colour(dataset, add_case, tmp_path, capsys):
    add_case('o_m_c', settings(), color=STAMPS, poses=STAMPS)
    arguments = parse(['import', str(dataset), 'o_m_c', '--out', str(tmp_path / 'out')])
    assert arguments.run(arguments) == EXIT_DONE
    said = capsys.readouterr()
    assert '0 depth, 3 colour frames' in said.out
    assert 'the bag holds 3 colour frames only' in said.err
    with pytest.raises(RecordingError, match=r'no depth topic, only .*/color/image_raw'):
        open_recording(tmp_path / 'out' / 'bag')


def parse(arguments):
    parser = argparse.ArgumentParser()
    import_command.add_parser(parser.add_subparsers())
    return parser.parse_args(arguments)


def test_what_is_there_is_kept_unless_overwriting(dataset, add_case, tmp_path):
    add_case('h_e_c', settings(), depth=STAMPS[:1])
    out = tmp_path / 'out'
    import_case(dataset, 'h_e_c', out)
    (out / 'scene.yaml').write_text('mine')
    with pytest.raises(RecordingError, match=r'scene.yaml exists already: .*--overwrite'):
        import_case(dataset, 'h_e_c', out)
    assert (out / 'scene.yaml').read_text() == 'mine'
    import_case(dataset, 'h_e_c', out, overwrite=True)
    assert yaml.safe_load((out / 'scene.yaml').read_text())['format'] == 1


def test_unknown_case_lists_the_known_ones(dataset, add_case):
    add_case('h_e_c', settings())
    add_case('t_mem_ c', settings())
    with pytest.raises(RecordingError, match=r"'h_e_x' is no experiment .* has h_e_c, t_mem_c"):
        open_case(dataset, 'h_e_x')


def test_other_folders_are_no_data_set(tmp_path):
    with pytest.raises(RecordingError, match='holds no exp_data folder'):
        open_case(tmp_path, 'h_e_c')


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'camera_intrinsics': None}, 'camera_intrinsics is missing: 9 numbers are needed'),
        ({'camera_intrinsics': '[1, 2]'}, r"camera_intrinsics is '\[1, 2\]': 9 numbers"),
        ({'camera_intrinsics': '[a]'}, r"is '\[a\]': 9 numbers are needed"),
        ({'camera_distortion': '[0.1]'}, 'a depth camera without distortion'),
        ({'object_transform': [0.5] * 16}, 'object_transform is not rigid'),
        ({'camera_transform': [0.5] * 16}, 'only the identity is known'),
        ({'held': '1, 2, 3'}, 'boxes of six limits each'),
        ({'object_data_path': None}, 'object_data_path is missing: a path is needed'),
        ({'object_data_path': 'CAD_models/none'}, r'none, which holds 0 .tet files'),
        ({'held': '9.0, inf, -inf, inf, -inf, inf'}, 'no vertex of the mesh lies in the clamped'),
        ({'regions': f'{ALL}, {ALL}'}, '1 materials in the name, 2 region boxes'),
    ],
)
def test_wrong_settings_are_told(dataset, add_case, changes, message):
    add_case('h_e_c', settings(**changes))
    with pytest.raises(RecordingError, match=message):
        open_case(dataset, 'h_e_c')


@pytest.mark.parametrize(
    ('name', 'message'),
    [('h_x_c', "'h_x_c' does not tell the material"), ('q_e_c', "starts with 'q': h, t, o are")],
)
def test_names_that_say_nothing_are_told(dataset, add_case, name, message):
    add_case(name, settings())
    with pytest.raises(RecordingError, match=message):
        open_case(dataset, name)


@pytest.mark.parametrize(
    ('name', 'content', 'message'),
    [
        ('d', np.zeros((5, 5), np.float32), r'float32 of shape \(5, 5\): depth in metres'),
        ('d', np.zeros((768, 1024), np.uint16), 'uint16 of shape'),
        ('c', np.zeros((720, 1280), np.uint8), r'bytes of shape \(720, 1280, 3\)'),
        ('v_0', np.zeros((4, 4)), 'is not rigid'),
        ('d', b'version https://git-lfs.github.com', 'git-lfs has to fetch'),
    ],
)
def test_wrong_frames_are_told(dataset, add_case, tmp_path, name, content, message):
    add_case('h_e_c', settings(), depth=STAMPS[:1], color=STAMPS[:1], poses=STAMPS[:1])
    file = dataset / 'exp_data/h_e_c/camera_data' / f'{name}_{STAMPS[0]}.npy'
    if isinstance(content, bytes):
        file.write_bytes(content)
    else:
        np.save(file, content)
    with pytest.raises(RecordingError, match=message):
        import_case(dataset, 'h_e_c', tmp_path / 'out')
    assert not (tmp_path / 'out' / 'scene.yaml').exists()
