# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal diagnose`, `accept` and `revert` on a recording with a hidden fault."""

import json
from pathlib import Path

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.cli.commands.diagnose import _suggest_solver
from diffcal_ros.cli.main import main
from diffcal_ros.errors import SceneError
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model_file import model_path
import pytest

from benchmarks.blind.generator import main as generate

# A case of the independent generator: the second half of the body reads nearer than it is.
CASE, EFFECT = 'case_001', 'depth_bias_by_region'


@pytest.fixture(scope='module')
def hidden(tmp_path_factory):
    """A diagnosed recording of a body whose fault is known to the label alone."""
    folder = tmp_path_factory.mktemp('hidden')
    generate(['--set', 'development', '--out', str(folder), '--only', CASE, '--jobs', '1'])
    scene, out = folder / 'cases' / CASE / 'scene.yaml', folder / 'out'
    done = main(['diagnose', '--scene', str(scene), '--out', str(out), '--pose', 'stored'])
    assert done == 0
    return folder


def scene_of(folder: Path) -> Path:
    return folder / 'cases' / CASE / 'scene.yaml'


def verdict_of(folder: Path) -> dict:
    return json.loads((folder / 'out' / 'verdict.json').read_text())


def test_the_hidden_effect_is_in_the_verdict(hidden):
    verdict = verdict_of(hidden)
    assert verdict['verdict'] == 'disagree'
    assert EFFECT in verdict['ambiguity_set']
    assert verdict['gap_mm']['added'] < 0.5 * verdict['gap_mm']['nominal']
    page = (hidden / 'out' / 'diagnosis.html').read_text()
    assert EFFECT in page
    assert 'http://' not in page
    assert 'https://' not in page


def test_accept_puts_it_into_the_model_and_revert_takes_it_out(hidden, capsys):
    scene = scene_of(hidden)
    before = scene.read_bytes()
    assert main(['accept', str(hidden / 'out')]) == 0
    assert scene.read_bytes() == before
    inputs = open_inputs(load_scene(scene), [], pose_source='stored')
    assert f'{EFFECT}.bias' in inputs.scene.fit
    assert any(EFFECT in note for note in inputs.scene.notes)
    assert main(['accept', str(hidden / 'out')]) == 2
    assert 'in the model already' in capsys.readouterr().err
    assert main(['revert', str(hidden / 'out')]) == 0
    inputs = open_inputs(load_scene(scene), [], pose_source='stored')
    assert inputs.scene.effects == {}
    assert f'{EFFECT}.bias' not in inputs.scene.fit
    assert main(['revert', str(scene)]) == 2
    assert model_path(scene).is_file()


@pytest.mark.slow
def test_accept_is_used_by_the_next_calibration_until_it_is_reverted(hidden):
    scene = scene_of(hidden)
    assert main(['accept', str(hidden / 'out')]) == 0
    inputs = open_inputs(load_scene(scene), [], pose_source='stored')
    with_it = calibrate(inputs.scene, inputs.observations)
    label = json.loads((hidden / 'labels' / f'{CASE}.json').read_text())
    (truth,) = (effect['amplitude'] for effect in label['effects'])
    assert with_it[f'{EFFECT}.bias'].value == pytest.approx(1e-3 * truth['tip'], abs=3e-4)
    modulus = with_it['youngs_modulus']
    assert modulus.value == pytest.approx(label['parameters']['youngs_modulus'], rel=0.05)
    assert main(['revert', str(hidden / 'out')]) == 0
    inputs = open_inputs(load_scene(scene), [], pose_source='stored')
    without = calibrate(inputs.scene, inputs.observations)
    assert with_it.gap_end.median < without.gap_end.median


@pytest.mark.parametrize(
    ('arguments', 'told'),
    [
        (['accept', 'nowhere'], 'diffcal diagnose'),
        (['revert', 'nowhere.yaml'], 'no effect'),
        (['diagnose', '--scene', '{scene}', '--out', 'x', '--without', 'ghosts'], 'ghosts'),
        (['diagnose', '--scene', '{scene}', '--out', 'x', '--margin', '-1'], 'margin'),
        (['diagnose', '--scene', '{scene}', '--out', 'x', '--fit', 'ghosts'], 'ghosts'),
    ],
)
def test_mistakes_are_told_in_one_sentence(arguments, told, hidden, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    filled = [part.format(scene=scene_of(hidden)) for part in arguments]
    assert main(filled) == 2
    message = capsys.readouterr().err
    assert told in message
    assert 'Traceback' not in message


def test_a_spoilt_model_file_is_refused(hidden):
    scene = scene_of(hidden)
    path = model_path(scene)
    old = path.read_text() if path.exists() else None
    path.write_text('format: 1\nversions: [{effect: ghosts}]\n')
    try:
        with pytest.raises(SceneError, match='restore it'):
            load_scene(scene)
    finally:
        path.unlink() if old is None else path.write_text(old)


@pytest.mark.parametrize(
    ('seconds', 'installed', 'is_told'),
    [(90.0, None, True), (90.0, 'cholmod', False), (9.0, None, False)],
)
def test_who_waits_long_is_told_of_a_faster_solver(
    monkeypatch, capsys, seconds, installed, is_told
):
    monkeypatch.setattr('diffcal_ros.fem.linear_solvers.fast_solver', lambda: installed)
    _suggest_solver(seconds)
    assert ("pip install 'diffcal_ros[fast]'" in capsys.readouterr().err) == is_told
