# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal calibrate --field` from the outside."""

import json

from diffcal_ros.cli.main import EXIT_BAD_INPUT, EXIT_DONE
import meshio
import numpy as np
import pytest


@pytest.mark.slow
def test_a_field_is_fitted_drawn_and_written(run_cli, recorded_beam, tmp_path) -> None:
    out = tmp_path / 'fit'
    done = run_cli(
        'calibrate',
        recorded_beam.bags['observation'],
        '--scene',
        recorded_beam.scene,
        '--out',
        out,
        '--field',
        '--field-spacing',
        '0.02',
        '--no-mesh-error',
    )
    assert done.code == EXIT_DONE
    assert {path.name for path in out.iterdir()} == {
        'result.json',
        'report.html',
        'fitted_scene.yaml',
        'field.vtu',
    }
    result = json.loads((out / 'result.json').read_text())
    assert result['field']['kind'] == 'a control grid of 20 mm'
    assert result['field']['weights'][0]['weight'] <= 1.0
    # The truth is one modulus: so is the field, to what it says it may be off.
    moduli = meshio.read(out / 'field.vtu').cell_data['youngs_modulus'][0]
    assert np.ptp(np.log(moduli)) < 0.5
    assert "Young's modulus over the body" in (out / 'report.html').read_text()
    assert 'field       a control grid' in done.out


@pytest.mark.parametrize(
    ('options', 'words'),
    [
        (('--field-spacing', '0.02'), 'say how to fit a field: add --field'),
        (('--field-weight', '0.1'), 'say how to fit a field: add --field'),
        (('--field', '--law', 'all'), 'fit the field under one law'),
        (('--field', '--loss', 'l1'), 'needs the robust loss'),
        (('--field', '--field-spacing', '3'), 'control grid has a spacing of 3 m'),
        (('--field', '--field-weight', '7'), 'weight of the roughness is 7'),
    ],
)
def test_options_that_do_not_go_together(run_cli, recorded_beam, tmp_path, options, words) -> None:
    done = run_cli(
        'calibrate',
        recorded_beam.bags['observation'],
        '--scene',
        recorded_beam.scene,
        '--out',
        tmp_path / 'fit',
        *options,
    )
    assert done.code == EXIT_BAD_INPUT
    assert words in done.err
    assert not (tmp_path / 'fit' / 'field.vtu').exists()
