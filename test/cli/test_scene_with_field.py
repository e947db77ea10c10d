# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fitted field goes on living: every command takes the fitted scene that states it."""

import json
from pathlib import Path
import shutil

from diffcal_ros.cli.main import EXIT_DONE, main
from diffcal_ros.prediction.film_times import FilmTimes
from diffcal_ros.prediction.predicted_body import predict_bodies
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.load import load_scene
import meshio
import numpy as np
import pytest
from support.recorded_beam import DEPTH_CAMERA, record_beam
import yaml

STIFF, SOFT = 160e3, 60e3
_OTHER = {'poissons_ratio': 0.45, 'density': 1080}
_HALVES = {
    'stiff': {'box': {'x': [0.06, float('inf')]}, 'youngs_modulus': STIFF, **_OTHER},
    'soft': {'rest': True, 'youngs_modulus': SOFT, **_OTHER},
}
_CAMERA = {
    name: getattr(DEPTH_CAMERA, name) for name in ('width', 'height', 'fx', 'fy', 'cx', 'cy')
}
# Equilibria from rest and from a neighbour agree to what Newton's method leaves [m].
SAME_PLACE = 1e-9
QUICK = ('--no-mesh-error',)


@pytest.fixture(scope='module')
def fitted(tmp_path_factory) -> tuple[Path, Path]:
    """The folder of a fit with a field to a body of two halves, and its recording."""
    return _fitted_halves(tmp_path_factory.mktemp('halves'), frames=4)


def _fitted_halves(folder: Path, *, frames: int) -> tuple[Path, Path]:
    settings = {'regions': _HALVES, 'camera': _CAMERA}
    made = record_beam(folder, settings, frames=frames, start_factor=1.0)
    document = yaml.safe_load(made.scene.read_text())
    document['regions'] = {'body': {'youngs_modulus': 1e5, **_OTHER}}
    made.scene.write_text(yaml.safe_dump(document))
    bag, out = made.bags['observation'], folder / 'fit'
    asked = ['--scene', made.scene, '--out', out, '--field', *QUICK]
    assert main([str(word) for word in ('calibrate', bag, *asked)]) == EXIT_DONE
    return out, bag


def test_the_fitted_scene_bends_as_the_fit_does(fitted):
    out, _ = fitted
    scene = load_scene(out / 'fitted_scene.yaml')
    content = meshio.read(out / 'field.vtu')
    (setup,) = scene.observations
    moved = content.points + content.point_data[f'displacement_{setup.name}']
    (body,) = predict_bodies(scene, FilmTimes())
    here = body.positions[0][: scene.mesh.vertex_count]
    assert np.abs(here - apply(setup.world_from_object, moved)).max() < SAME_PLACE
    assert body.largest_displacement > 5e-3
    # Its field is the one that was fitted, and no uniform body does as well.
    of_tets = scene.regions[0].youngs_modulus.start * scene.relative_modulus
    np.testing.assert_allclose(of_tets, content.cell_data['youngs_modulus'][0], rtol=1e-12)
    assert np.median(of_tets[scene.mesh.centroids[:, 0] > 0.07]) > 1.5 * np.median(
        of_tets[scene.mesh.centroids[:, 0] < 0.05]
    )


def test_it_is_checked_and_drawn(fitted, run_cli, tmp_path):
    done = run_cli('check', fitted[0] / 'fitted_scene.yaml', '--draw', tmp_path / 'scene.png')
    assert done.code == EXIT_DONE
    assert "times its region's" in done.out
    assert (tmp_path / 'scene.png').is_file()


def test_it_is_predicted(fitted, run_cli, tmp_path):
    done = run_cli('predict', fitted[0] / 'fitted_scene.yaml', '--out', tmp_path / 'film')
    assert done.code == EXIT_DONE
    assert (tmp_path / 'film' / 'depth.png').is_file()


@pytest.mark.slow
def test_a_fit_of_one_number_scales_it(fitted, run_cli, tmp_path):
    folder, bag = fitted
    scene = folder / 'fitted_scene.yaml'
    document = yaml.safe_load(scene.read_text())
    start = document['regions']['body']['youngs_modulus']
    document['regions']['body']['youngs_modulus'] = 1.5 * start
    (folder / 'stiffer.yaml').write_text(yaml.safe_dump(document))
    out = tmp_path / 'again'
    done = run_cli('calibrate', bag, '--scene', folder / 'stiffer.yaml', '--out', out, *QUICK)
    assert done.code == EXIT_DONE
    # What the fit came from is on record, the field included.
    result = json.loads((out / 'result.json').read_text())
    assert result['scene']['modulus_field_sha256']
    before = json.loads((folder / 'result.json').read_text())
    # The same pixels under the same field: the factor that was put in comes off again.
    again = load_scene(out / 'fitted_scene.yaml')
    assert again.regions[0].youngs_modulus.start == pytest.approx(start, rel=0.02)
    np.testing.assert_array_equal(again.relative_modulus, load_scene(scene).relative_modulus)
    assert result['gap']['end']['rms_mm'] < 1.05 * before['gap']['end']['rms_mm']


@pytest.mark.slow
def test_a_field_is_added_to_it(fitted, run_cli, tmp_path):
    folder, bag = fitted
    scene = folder / 'fitted_scene.yaml'
    out = tmp_path / 'again'
    done = run_cli('calibrate', bag, '--scene', scene, '--out', out, '--field', *QUICK)
    assert done.code == EXIT_DONE
    first, second = (load_scene(path / 'fitted_scene.yaml') for path in (folder, out))
    moduli = [s.regions[0].youngs_modulus.start * s.relative_modulus for s in (first, second)]
    # The residuals are at the noise already: what the same data add is within the error.
    written = meshio.read(out / 'field.vtu').cell_data
    added = np.abs(np.log(moduli[1] / moduli[0]))
    assert 0.0 < np.median(added / written['log_std_error'][0]) < 1.0
    np.testing.assert_allclose(moduli[1], written['youngs_modulus'][0], rtol=1e-12)


@pytest.mark.slow
def test_it_is_recorded_and_its_recording_fitted(fitted, run_cli, tmp_path):
    twin = tmp_path / 'twin'
    scene = fitted[0] / 'fitted_scene.yaml'
    done = run_cli('simulate', scene, '--out', twin, '--frames', 3)
    assert done.code == EXIT_DONE
    assert json.loads((twin / 'truth.json').read_text())['modulus_field'] == 'field.vtu'
    first, second = load_scene(scene), load_scene(twin / 'scene.yaml')
    np.testing.assert_array_equal(second.relative_modulus, first.relative_modulus)
    done = run_cli('calibrate', '--scene', twin / 'scene.yaml', '--out', tmp_path / 'fit', *QUICK)
    assert done.code == EXIT_DONE
    found = json.loads((tmp_path / 'fit' / 'result.json').read_text())
    truth = first.regions[0].youngs_modulus.start
    assert found['parameters']['youngs_modulus']['value'] == pytest.approx(truth, rel=0.02)


@pytest.mark.slow
def test_a_diagnosis_finds_less_that_is_wrong(run_cli, tmp_path):
    # Two frames leave the floor a guess. By one that is measured, what the outline at the clamp
    # leaves is most of what is found, with the field and without.
    folder, bag = _fitted_halves(tmp_path, frames=2)
    document = yaml.safe_load((folder / 'fitted_scene.yaml').read_text())
    del document['modulus_field']
    (folder / 'uniform.yaml').write_text(yaml.safe_dump(document))
    misfit = {}
    for name in ('fitted_scene', 'uniform'):
        run_cli('diagnose', bag, '--scene', folder / f'{name}.yaml', '--out', tmp_path / name)
        verdict = json.loads((tmp_path / name / 'verdict.json').read_text())
        misfit[name] = verdict['details']['chi_square_per_patch']
    assert misfit['fitted_scene'] < 0.5 * misfit['uniform']


@pytest.mark.slow
def test_a_fit_into_the_folder_that_it_reads_loses_nothing(fitted, run_cli, monkeypatch):
    folder = fitted[0].with_name('copy')
    shutil.copytree(fitted[0], folder)
    scene = folder / 'fitted_scene.yaml'
    before = load_scene(scene).relative_modulus
    monkeypatch.setattr('diffcal_ros.cli.progress.Progress.step', lambda *_: False)
    run_cli('calibrate', fitted[1], '--scene', scene, '--out', folder, *QUICK)
    np.testing.assert_array_equal(load_scene(scene).relative_modulus, before)
