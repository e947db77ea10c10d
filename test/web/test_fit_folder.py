# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fit's folder read again."""

import json
import shutil

from diffcal_ros.errors import InputError
from diffcal_ros.web.fit_folder import read_fit
from diffcal_ros.web.fit_words import fit_words, gap_words
import numpy as np
import pytest


def test_the_model_stands_where_the_fit_ended(fitted_beam):
    fit = read_fit(fitted_beam.folder)
    calibration = fit.calibration(fit.open())
    gap = calibration.objective.gap(calibration.coordinates)
    told = json.loads((fitted_beam.folder / 'result.json').read_text())['gap']['end']
    # The scales that decide what counts move a little while a fit runs.
    assert 1e3 * gap.median == pytest.approx(told['median_mm'], rel=0.02)
    assert gap.coverage == pytest.approx(told['coverage'], abs=0.01)


def test_a_fit_that_moved_takes_recordings_that_are_given(fitted_beam, tmp_path):
    folder = tmp_path / 'moved'
    shutil.copytree(fitted_beam.folder, folder)
    document = json.loads((folder / 'result.json').read_text())
    document['recordings'][0]['path'] = str(tmp_path / 'gone')
    (folder / 'result.json').write_text(json.dumps(document))
    scene = folder / 'fitted_scene.yaml'
    kept = [line for line in scene.read_text().splitlines() if not line.startswith('bag:')]
    mesh = json.dumps(str(read_fit(fitted_beam.folder).scene.file_of('mesh').resolve()))
    kept = [f'mesh: {{file: {mesh}, unit: mm}}' if 'mesh:' in line else line for line in kept]
    scene.write_text('\n'.join(kept))
    fit = read_fit(folder)
    with pytest.raises(InputError, match='give the recordings after the folder'):
        fit.open()
    assert len(fit.open([fitted_beam.bag]).observations) == 1


def test_a_folder_without_a_result_is_told(tmp_path):
    with pytest.raises(InputError, match=r'holds no result.json'):
        read_fit(tmp_path)
    (tmp_path / 'result.json').write_text('{"outcome": "converged"}')
    with pytest.raises(InputError, match='is no result'):
        read_fit(tmp_path)


def test_the_words_hold_modulus_error_outcome_and_gap(fitted_beam):
    fit = read_fit(fitted_beam.folder)
    words = fit_words('a *beam*', fit.document)
    assert r'a \*beam\*' in words
    assert 'converged: The fit is done.' in words
    own = fit.document['parameters']['youngs_modulus']
    assert f'{1e-3 * own["std_error"]:.2g} kPa' in words
    assert 'camera pose' not in words
    assert 'gap: median' in words


def test_a_body_that_was_not_seen_has_no_gap():
    nothing = {'median_mm': None, 'rms_mm': None, 'coverage': 0.0, 'explained': None}
    assert gap_words(nothing) == 'gap: nothing measured lies on the simulated body'
    seen = {'median_mm': 0.25, 'rms_mm': 1.0, 'coverage': 0.985, 'explained': np.nan}
    assert gap_words(seen) == 'gap: median 0.25 mm, RMS 1 mm on 98% of the body'
