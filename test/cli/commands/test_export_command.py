# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal export` from the outside."""

import json
import shutil
import subprocess
import sys

from diffcal_ros.cli.main import EXIT_BAD_INPUT, EXIT_DONE
import pytest
from support.recorded_beam import write_beam_scene


def test_a_fit_s_folder_becomes_files_and_a_list(run_cli, tmp_path):
    fit = tmp_path / 'fit'
    shutil.move(write_beam_scene(fit), fit / 'fitted_scene.yaml')
    out = tmp_path / 'asset'
    ran = run_cli('export', fit, '--to', 'vtk', '--out', out)
    assert ran.code == EXIT_DONE
    assert sorted(path.name for path in out.iterdir()) == [
        'body.vtu',
        'export.json',
        'play_vtk.py',
    ]
    listed = json.loads((out / 'export.json').read_text())
    volume = 0.12 * 0.024 * 0.02
    assert listed['mass'] == pytest.approx(1080 * volume, rel=1e-9)
    assert listed['regions']['body']['youngs_modulus'] == pytest.approx(90e3)
    assert f'mass    {1e3 * 1080 * volume:.4g} g' in ran.out
    played = subprocess.run(
        [sys.executable, out / 'play_vtk.py'], capture_output=True, text=True, check=True
    )
    assert '0.06221 kg' in played.stdout


def test_what_was_fitted_for_the_target_is_taken(run_cli, tmp_path):
    fit = tmp_path / 'fit'
    shutil.move(write_beam_scene(fit), fit / 'fitted_scene.yaml')
    found = {
        'moduli': {'youngs_modulus': {'effective': {'value': 61e3}}},
        'poissons_ratios': {'body': {'effective': 0.2}},
    }
    (fit / 'result.json').write_text(json.dumps({'effective': {'sofa': found}}))

    def exported(*options):
        ran = run_cli('export', fit, '--out', tmp_path / 'asset', *options)
        assert ran.code == EXIT_DONE
        listed = json.loads((tmp_path / 'asset' / 'export.json').read_text())
        body = listed['regions']['body']
        return listed['moduli'], body['youngs_modulus'], body['poissons_ratio']

    material = ('material', pytest.approx(90e3), pytest.approx(0.45))
    assert exported('--to', 'sofa') == (
        'effective for sofa',
        pytest.approx(61e3),
        pytest.approx(0.2),
    )
    assert exported('--to', 'sofa', '--modulus', 'material') == material
    # Nothing was fitted for MuJoCo, and VTK simulates nothing.
    assert exported('--to', 'mjcf') == material
    assert exported('--to', 'vtk') == material
    (fit / 'result.json').write_text('[]')
    ran = run_cli('export', fit, '--to', 'sofa', '--out', tmp_path / 'asset')
    assert ran.code == EXIT_BAD_INPUT
    assert 'is no result of `diffcal calibrate`' in ran.err


def test_calibrate_for_a_simulator_and_export_to_it(run_cli, recorded_beam, tmp_path):
    fit, asset = tmp_path / 'fit', tmp_path / 'asset'
    bag = recorded_beam.bags['observation']
    options = ('--no-search', '--no-mesh-error', '--max-iterations', 6, '--for', 'sofa')
    ran = run_cli('calibrate', bag, '--scene', recorded_beam.scene, '--out', fit, *options)
    assert "sofa       the material's" in ran.out
    found = json.loads((fit / 'result.json').read_text())['effective']['sofa']
    value = found['moduli']['youngs_modulus']['effective']['value']
    assert value < found['moduli']['youngs_modulus']['material']['value']
    assert 'In other simulators' in (fit / 'report.html').read_text()
    exported = run_cli('export', fit, '--to', 'sofa', '--out', asset)
    assert 'moduli  effective for sofa' in exported.out
    listed = json.loads((asset / 'export.json').read_text())
    assert listed['regions']['body']['youngs_modulus'] == pytest.approx(value)


@pytest.mark.slow
def test_a_simulator_that_cannot_be_fitted_costs_no_report(run_cli, recorded_beam, tmp_path):
    bag, fit = recorded_beam.bags['observation'], tmp_path / 'fit'
    options = ('--no-search', '--no-mesh-error', '--fit', 'rigid_offset', '--for', 'sofa')
    ran = run_cli('calibrate', bag, '--scene', recorded_beam.scene, '--out', fit, *options)
    assert ran.code == EXIT_BAD_INPUT
    assert "--for: no Young's modulus was fitted" in ran.err
    assert sorted(path.name for path in fit.iterdir()) == [
        'fitted_scene.yaml',
        'report.html',
        'result.json',
    ]


def test_for_goes_with_one_robust_fit(run_cli, recorded_beam, tmp_path):
    options = ('--scene', recorded_beam.scene, '--out', tmp_path / 'fit', '--for', 'sofa')
    ran = run_cli('calibrate', *options, '--law', 'all')
    assert ran.code == EXIT_BAD_INPUT
    assert 'leave out --law all and --loss, or it' in ran.err


def test_mistakes_are_told(run_cli, tmp_path):
    nothing = run_cli('export', tmp_path, '--to', 'vtk', '--out', tmp_path / 'asset')
    assert nothing.code == EXIT_BAD_INPUT
    assert 'holds no fitted_scene.yaml: give the folder of a `diffcal calibrate`' in nothing.err
    scene = write_beam_scene(tmp_path)
    other = run_cli(
        'export', scene, '--to', 'vtk', '--out', tmp_path / 'asset', '--observation', 'swing'
    )
    assert other.code == EXIT_BAD_INPUT
    assert "observation is 'swing': the scene has observation" in other.err
    assert not (tmp_path / 'asset').exists()


def test_a_missing_package_is_named(run_cli, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'pxr', None)
    ran = run_cli('export', write_beam_scene(tmp_path), '--to', 'usd', '--out', tmp_path / 'asset')
    assert ran.code == EXIT_BAD_INPUT
    assert "install it with `pip install 'diffcal_ros[usd]'`" in ran.err
