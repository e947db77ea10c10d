# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal calibrate` from the outside: files, table, progress, exit codes, a full disk."""

from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
import fcntl
import hashlib
from io import StringIO
import json
import os
from pathlib import Path
import resource
import shutil
import signal
import struct
import subprocess
import sys
import termios
from typing import Any

from diffcal_ros.cli.command_list import calibrate as calibrate_command
from diffcal_ros.cli.main import EXIT_BAD_INPUT, EXIT_DONE, EXIT_NOT_FITTED, main
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from support.recorded_beam import MODULUS
from support.scene_files import EXACT_POSE

FILES = {'result.json', 'report.html', 'fitted_scene.yaml'}
# Where the mesh's error is not what a test is about.
QUICK = '--no-mesh-error'
OFFSET_AXES = ('x', 'y', 'z', 'rx', 'ry', 'rz')


def names(folder):
    return {path.name for path in folder.iterdir()}


def read_result(folder):
    return json.loads((folder / 'result.json').read_text())


@dataclass(frozen=True)
class Done:
    """One whole run that several tests look at."""

    folder: Path
    result: dict[str, Any]
    out: str
    err: str


@pytest.fixture(scope='module')
def done(recorded_beam, tmp_path_factory) -> Done:
    folder, out, err = tmp_path_factory.mktemp('out'), StringIO(), StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        bag = recorded_beam.bags['observation']
        code = main(
            ['calibrate', str(bag), '--scene', str(recorded_beam.scene), '--out', str(folder)]
        )
    assert code == EXIT_DONE
    return Done(folder, read_result(folder), out.getvalue(), err.getvalue())


@pytest.fixture
def calibrate(run_cli, recorded_beam, tmp_path):
    """Calibrate the recorded beam into `out`; return what ran."""

    def run(*options, scene=recorded_beam.scene):
        return run_cli('calibrate', '--scene', scene, '--out', tmp_path / 'out', *options)

    return run


def test_results_are_written_and_hold_the_truth(done):
    assert names(done.folder) == FILES
    result = done.result
    assert result['outcome'] == 'converged'
    modulus = result['parameters']['youngs_modulus']
    assert modulus['unit'] == 'Pa'
    assert modulus['start'] == pytest.approx(1.4 * MODULUS)
    # The data are of the very mesh that is fitted: there is no mesh error to be taken off.
    assert abs(np.log(modulus['value'] / MODULUS)) < 1.96 * modulus['std_error'] / modulus['value']
    low, high = modulus['interval_95']
    assert low < modulus['fine_mesh_value'] < high
    start, end = result['gap']['start'], result['gap']['end']
    assert set(end) == {
        'median_mm',
        'rms_mm',
        'coverage',
        'explained',
        'hidden',
        'pixels',
    }
    assert end['rms_mm'] < 0.5 * start['rms_mm']
    assert end['coverage'] > start['coverage']
    assert result['loss']['name'] == 'robust'
    assert result['iterations'] == result['history'][-1]['iteration'] > 0
    assert result['seconds'] > 0.0
    assert {'diffcal_ros', 'numpy', 'scipy', 'warp'} <= set(result['versions'])


def test_the_inputs_are_known_by_their_hashes(done, recorded_beam):
    result, folder = done.result, recorded_beam.scene.parent
    (recording,) = result['recordings']
    (mcap,) = recorded_beam.bags['observation'].glob('*.mcap')
    for found, file in (
        (result['scene']['sha256'], recorded_beam.scene),
        (result['scene']['mesh_sha256'], folder / 'beam.tet'),
        (recording['sha256'], mcap),
    ):
        assert found == hashlib.sha256(file.read_bytes()).hexdigest()


def test_the_table_is_short_and_progress_goes_elsewhere(done):
    lines = done.out.splitlines()
    assert len(lines) < 20
    assert lines[0] == 'beam: converged'
    assert any(line.startswith("Young's modulus  ") and '126 kPa' in line for line in lines)
    assert f'result  {done.folder / "result.json"}' in lines
    assert 'iteration 0: loss' not in done.out
    steps = [line for line in done.err.splitlines() if line.startswith('iteration ')]
    assert len(steps) == done.result['iterations'] + 1


@pytest.mark.slow
def test_a_terminal_gets_a_bar(calibrate, monkeypatch):
    leader, follower = os.openpty()
    fcntl.ioctl(follower, termios.TIOCSWINSZ, struct.pack('HHHH', 40, 120, 0, 0))
    with os.fdopen(follower, 'w') as terminal:
        monkeypatch.setattr(sys, 'stderr', terminal)
        assert calibrate('--max-iterations', '2', QUICK).code == EXIT_NOT_FITTED
        terminal.flush()
        shown = os.read(leader, 65536).decode()
    os.close(leader)
    assert 'fitting      |' in shown
    assert '2/2' in shown
    assert 'kPa' in shown.rpartition('2/2')[2]


def test_the_fitted_scene_starts_where_the_fit_ended(done):
    fitted = load_scene(done.folder / 'fitted_scene.yaml')
    value = done.result['parameters']['youngs_modulus']['value']
    assert fitted.regions[0].youngs_modulus.start == pytest.approx(value, rel=1e-12)


@pytest.mark.slow
def test_what_the_data_cannot_tell_is_code_3_and_no_scene(calibrate, tmp_path):
    (tmp_path / 'out').mkdir()
    (tmp_path / 'out' / 'fitted_scene.yaml').write_text('of an earlier run')
    ran = calibrate('--fit', 'youngs_modulus,density', QUICK)
    assert ran.code == EXIT_NOT_FITTED
    assert read_result(tmp_path / 'out')['outcome'] == 'not_identifiable'
    assert 'fit fewer of them, give a prior' in ran.out
    assert "warning: a body at rest shows only the ratio of Young's modulus to density" in ran.out
    assert names(tmp_path / 'out') == {'result.json', 'report.html'}


@pytest.mark.slow
def test_a_body_that_is_nowhere_in_the_image_is_code_3(calibrate, change_scene, tmp_path):
    scene = change_scene({'placement.translation': [-0.25, -0.055, -0.035]})
    ran = calibrate(QUICK, scene=scene)
    assert ran.code == EXIT_NOT_FITTED
    assert 'body not found' in ran.err
    assert 'beam: diverged' in ran.out
    assert 'check that the rendered body lies on the observed one' in ' '.join(ran.out.split())
    assert (tmp_path / 'out' / 'report.html').is_file()


@pytest.mark.slow
def test_options_reach_the_fit(calibrate, tmp_path):
    pytest.importorskip('torch', reason='adam_demon needs torch')
    options = ('--loss', 'l1', '--optimizer', 'adam_demon', '--max-iterations', '3', QUICK)
    ran = calibrate('--fit', 'youngs_modulus', 'rigid_offset', *options)
    result = read_result(tmp_path / 'out')
    assert ran.code == EXIT_NOT_FITTED
    assert result['outcome'] == 'not_converged'
    assert (result['loss']['name'], len(result['history'])) == ('l1', 3)
    assert result['settings']['optimizer'] == 'adam_demon'
    asked = [name for name, p in result['parameters'].items() if not p['nuisance']]
    assert asked == ['youngs_modulus', *(f'rigid_offset.{a}' for a in OFFSET_AXES)]


@pytest.mark.slow
def test_a_stored_pose_is_used_as_it_is(done, calibrate, change_scene, recorded_beam, tmp_path):
    truth = json.loads(recorded_beam.truth.read_text())
    pose = np.array(truth['observations']['observation']['depth_from_world'])
    pose[2, 3] += 0.005
    scene = change_scene(
        {
            'stored_depth_from_world': {
                'translation': pose[:3, 3].tolist(),
                'rotation_matrix': pose[:3, :3].tolist(),
            },
            'pose': EXACT_POSE,
        }
    )
    calibrate('--pose', 'stored', '--max-iterations', '1', QUICK, scene=scene)
    wrong = read_result(tmp_path / 'out')['gap']['start']['median_mm']
    # The body is seen 5 mm too far away.
    assert wrong == pytest.approx(5.0, abs=0.5)
    assert done.result['gap']['start']['median_mm'] < 1.0


@pytest.mark.slow
def test_an_interrupted_fit_keeps_its_last_state(recorded_beam, tmp_path):
    """A fit that would take hours is interrupted after its second step."""
    pytest.importorskip('torch', reason='adam_demon needs torch')
    # Tests that run in the background may ignore the signal, and so would what they start.
    code = 'import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); '
    code += 'from diffcal_ros.cli.main import main; sys.exit(main(sys.argv[1:]))'
    out = tmp_path / 'out'
    arguments = ['calibrate', '--scene', recorded_beam.scene, '--out', out, '--loss', 'paper']
    arguments += ['--optimizer', 'adam_demon', '--max-iterations', '1000000']
    with subprocess.Popen(
        [sys.executable, '-c', code, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        said = []
        for line in process.stderr:
            said.append(line)
            if line.startswith('iteration 2:'):
                process.send_signal(signal.SIGINT)
        printed = process.stdout.read()
    assert process.returncode == 130
    assert 'Traceback' not in ''.join(said)
    assert names(out) == {'result.json'}
    result = read_result(out)
    assert result['outcome'] == 'interrupted'
    assert result['iterations'] >= 2
    assert said[-1].rstrip().endswith(f'holds the state after iteration {result["iterations"]}')
    assert printed == ''


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """Let no file grow beyond some bytes, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_full_disk_leaves_no_part_of_a_result(calibrate, tmp_path):
    (tmp_path / 'out').mkdir()
    with largest_file(1000):
        ran = calibrate(QUICK)
    assert ran.code == EXIT_BAD_INPUT
    assert 'result.json cannot be written (File too large): see that' in ran.err.splitlines()[-1]
    assert names(tmp_path / 'out') == set()


@pytest.mark.slow
def test_a_disk_too_full_for_the_report_keeps_the_numbers(calibrate, tmp_path):
    with largest_file(60_000):
        ran = calibrate(QUICK)
    assert ran.code == EXIT_BAD_INPUT
    assert 'report.html cannot be written' in ran.err.splitlines()[-1]
    assert ran.out.startswith('beam: converged')
    assert names(tmp_path / 'out') == {'result.json', 'fitted_scene.yaml'}
    assert read_result(tmp_path / 'out')['outcome'] == 'converged'


def test_a_folder_in_place_of_a_file_is_told_before_the_fit(calibrate, tmp_path):
    (tmp_path / 'out' / 'report.html').mkdir(parents=True)
    ran = calibrate()
    assert ran.code == EXIT_BAD_INPUT
    assert 'report.html is a folder, and a file is to be written there: remove it' in ran.err
    assert names(tmp_path / 'out') == {'report.html'}


@pytest.mark.slow
def test_a_report_that_cannot_be_written_costs_no_scene(calibrate, tmp_path, monkeypatch):
    monkeypatch.setattr(calibrate_command, '_check_targets', lambda out: None)
    (tmp_path / 'out' / 'report.html').mkdir(parents=True)
    ran = calibrate()
    assert ran.code == EXIT_BAD_INPUT
    assert 'report.html is a folder' in ran.err
    assert ran.out.startswith('beam: converged')
    assert names(tmp_path / 'out') == FILES


def test_an_earlier_result_survives_a_full_disk(done, calibrate, tmp_path):
    shutil.copytree(done.folder, tmp_path / 'out')
    before = (tmp_path / 'out' / 'result.json').read_bytes()
    with largest_file(1000):
        assert calibrate(QUICK).code == EXIT_BAD_INPUT
    assert (tmp_path / 'out' / 'result.json').read_bytes() == before
    assert names(tmp_path / 'out') == FILES


@pytest.mark.slow
def test_all_laws_are_ranked(recorded_beam, tmp_path, capsys):
    bag = recorded_beam.bags['observation']
    arguments = ['calibrate', str(bag), '--scene', str(recorded_beam.scene), '--no-mesh-error']
    assert main([*arguments, '--out', str(tmp_path), '--law', 'all']) == EXIT_DONE
    out = capsys.readouterr().out.splitlines()
    ranking = json.loads((tmp_path / 'laws.json').read_text())
    laws = [entry['law'] for entry in ranking['ranked']]
    assert [line.split()[0] for line in out[1 : 1 + len(laws)]] == laws
    gaps = [entry['held_out_gap']['rms_mm'] for entry in ranking['ranked']]
    assert gaps == sorted(gaps)
    assert read_result(tmp_path / laws[0])['scene']['law'] == laws[0]


@pytest.mark.slow
def test_one_law_is_fitted_and_written_to_the_scene(recorded_beam, tmp_path):
    bag = recorded_beam.bags['observation']
    arguments = ['calibrate', str(bag), '--scene', str(recorded_beam.scene), '--no-mesh-error']
    assert main([*arguments, '--out', str(tmp_path), '--law', 'mooney_rivlin']) == EXIT_DONE
    assert load_scene(tmp_path / 'fitted_scene.yaml').law == 'mooney_rivlin'
    assert read_result(tmp_path)['scene']['law'] == 'mooney_rivlin'


def test_an_unknown_law_is_bad_input(recorded_beam, tmp_path, capsys):
    arguments = ['calibrate', '--scene', str(recorded_beam.scene), '--out', str(tmp_path)]
    assert main([*arguments, '--law', 'ogden']) == EXIT_BAD_INPUT
    assert "law is 'ogden': use one of stable_neo_hookean" in capsys.readouterr().err
