# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal init` from the outside: a scene from a mesh and a recording alone."""

from dataclasses import dataclass
from pathlib import Path

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.cli.main import EXIT_BAD_INPUT, EXIT_DONE, main
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from support.held_beam import film_in_bracket, FRONT, write_surface
from support.recorded_beam import MODULUS

MARKER = ('--marker', 'DICT_6X6_250:7:0.03')
# The beam's vertices are held from 105 mm of its 120 on, and so far its clamp's block reaches.
_FREE = 0.105


@dataclass(frozen=True)
class Proposed:
    """What the command wrote for the recorded beam."""

    code: int
    folder: Path


@pytest.fixture(scope='module')
def proposed(recorded_beam, tmp_path_factory) -> Proposed:
    """The beam's own mesh and recording, and nothing else that is known of it."""
    folder = tmp_path_factory.mktemp('init') / 'out'
    mesh = recorded_beam.scene.parent / 'beam.tet'
    bag = recorded_beam.bags['observation']
    code = main(['init', str(mesh), str(bag), *MARKER, '--out', str(folder)])
    return Proposed(code, folder)


@pytest.mark.slow
def test_the_proposed_scene_says_what_the_beam_is_and_what_is_not_sure(proposed):
    assert proposed.code == EXIT_DONE
    scene = load_scene(proposed.folder / 'scene.yaml')
    text = (proposed.folder / 'scene.yaml').read_text()
    assert scene.document['mesh']['unit'] == 'mm'
    assert scene.marker is not None
    assert scene.marker.id == 7
    assert scene.observations[0].gravity.tolist() == [0.0, -9.81, 0.0]
    assert '# check: the marker is taken to hang upright' in text
    assert '# check: 1080 kg/m^3 is the density of silicone' in text
    assert '<img src="data:image/png' in (proposed.folder / 'proposal.html').read_text()


@pytest.mark.slow
def test_the_clamp_begins_where_the_beam_disappears(proposed):
    scene = load_scene(proposed.folder / 'scene.yaml')
    ((_, limits),) = scene.document['held']['clamp']['box'].items()
    # A beam is the same from both ends.
    free = limits[0] if np.isinf(limits[1]) else 0.12 - limits[1]
    assert free == pytest.approx(_FREE, abs=0.003)


@pytest.mark.slow
def test_a_fit_of_the_proposed_scene_finds_the_modulus(proposed):
    inputs = open_inputs(load_scene(proposed.folder / 'scene.yaml'), [])
    result = calibrate(
        inputs.scene, inputs.observations, CalibrationSettings(with_mesh_error=False)
    )
    modulus = result['youngs_modulus']
    assert result.gap_end.median < 0.5e-3
    assert modulus.value == pytest.approx(MODULUS, rel=0.1)


@pytest.mark.slow
def test_a_folder_that_has_a_scene_is_kept(run_cli, proposed, recorded_beam):
    before = (proposed.folder / 'scene.yaml').read_text()
    mesh = recorded_beam.scene.parent / 'beam.tet'
    ran = run_cli(
        'init', mesh, recorded_beam.bags['observation'], *MARKER, '--out', proposed.folder
    )
    assert ran.code == EXIT_BAD_INPUT
    assert '--overwrite' in ran.err
    assert (proposed.folder / 'scene.yaml').read_text() == before


def test_a_body_of_twenty_metres_is_asked_about(run_cli, recorded_beam, tmp_path):
    source = (recorded_beam.scene.parent / 'beam.tet').read_text().splitlines()
    numbers = [line.split() for line in source]
    larger = [
        ' '.join(['v', *(str(2e2 * float(own)) for own in row[1:])]) if row[0] == 'v' else line
        for row, line in zip(numbers, source, strict=True)
        if row
    ]
    mesh = tmp_path / 'large.tet'
    mesh.write_text('\n'.join(larger) + '\n')
    ran = run_cli('init', mesh, recorded_beam.bags['observation'], *MARKER, '--out', tmp_path)
    assert ran.code == EXIT_BAD_INPUT
    assert 'in mm 24 m' in ran.err
    assert '--unit' in ran.err
    assert not (tmp_path / 'scene.yaml').exists()


def test_a_surface_with_a_hole_is_refused(run_cli, recorded_beam, tmp_path):
    mesh = tmp_path / 'open.obj'
    mesh.write_text('v 0 0 0\nv 100 0 0\nv 0 20 0\nv 0 0 20\nf 1 3 2\nf 1 2 4\nf 1 4 3\n')
    ran = run_cli('init', mesh, recorded_beam.bags['observation'], *MARKER, '--out', tmp_path)
    assert ran.code == EXIT_BAD_INPUT
    assert 'not watertight' in ran.err


def test_two_depth_topics_must_be_chosen_between(run_cli, change_bag, recorded_beam, tmp_path):
    from diffcal_ros.recording.bag_reader import open_recording
    from diffcal_ros.recording.topics.ros_messages import image_message

    source = open_recording(recorded_beam.bags['observation'])
    frame = next(iter(source.depth_frames()))

    def second(bag, stamp):
        bag.write(
            '/other/depth/image',
            image_message(frame.depth, encoding='32FC1', stamp_ns=stamp, frame_id='other'),
            stamp,
        )

    bag = change_bag(extra=second)
    mesh = recorded_beam.scene.parent / 'beam.tet'
    ran = run_cli('init', mesh, bag, *MARKER, '--out', tmp_path / 'out')
    assert ran.code == EXIT_BAD_INPUT
    assert '--depth-topic' in ran.err


@pytest.mark.parametrize(
    ('given', 'told'),
    [
        ('DICT_6X6_250:7', 'DICT:ID:SIDE'),
        ('DICT_6X6_251:7:0.03', 'is none of'),
        ('DICT_6X6_250:250:0.03', 'markers 0 to 249'),
        ('DICT_6X6_250:7:30', 'in metres'),
        ('DICT_6X6_250:x:0.03', 'whole number'),
    ],
)
def test_a_marker_that_cannot_be_is_refused(capsys, tmp_path, given, told):
    with pytest.raises(SystemExit):
        main(['init', 'body.stl', 'take', '--marker', given, '--out', str(tmp_path)])
    assert told in capsys.readouterr().err


@pytest.mark.slow
def test_the_cad_of_a_clamp_stands_in_for_a_marker(recorded_beam, tmp_path):
    held = film_in_bracket(recorded_beam, tmp_path / 'bag')
    write_surface(held.scene.fixture, tmp_path / 'bracket.obj')
    mesh, out = recorded_beam.scene.parent / 'beam.tet', tmp_path / 'out'
    given = ['--fixture', str(tmp_path / 'bracket.obj'), '--unit', 'mm', '--gravity=0,-9.81,0']
    # The recorder's Poisson's ratio; that of rubber is the command's own.
    given += ['--poissons-ratio', '0.45', '--density', '1080']
    assert main(['init', str(mesh), str(held.bag), *given, '--out', str(out)]) == EXIT_DONE
    scene = load_scene(out / 'scene.yaml')
    assert scene.observations[0].pose.source == 'fixture'
    np.testing.assert_allclose(scene.observations[0].world_from_object, np.eye(4), atol=1e-12)
    assert scene.document['held']['clamp']['box']['x'][0] == pytest.approx(FRONT, abs=0.003)
    fitted = calibrate(scene, open_inputs(scene, []).observations)['youngs_modulus']
    assert fitted.value == pytest.approx(MODULUS, rel=0.08)
