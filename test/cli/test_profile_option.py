# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal calibrate --profile`: intervals in the table, the JSON and the page; wrong names."""

import json

from diffcal_ros.calibration.uncertainty.profile import Profile
from diffcal_ros.report.tables.result_table import profile_lines
import numpy as np
import pytest


@pytest.fixture
def calibrate(run_cli, recorded_beam, tmp_path):
    """Calibrate the recorded beam into `tmp_path`/out."""
    bag = recorded_beam.bags['observation']
    shared = ('calibrate', bag, '--scene', recorded_beam.scene, '--no-mesh-error')
    return lambda *options: run_cli(*shared, '--out', tmp_path / 'out', *options)


@pytest.mark.slow
def test_profile_is_told_everywhere(calibrate, tmp_path):
    ran = calibrate('--profile', 'youngs_modulus')
    assert ran.code == 0
    assert "profile     Young's modulus: 95 %" in ran.out
    content = json.loads((tmp_path / 'out' / 'result.json').read_text())
    own, fitted = content['profiles']['youngs_modulus'], content['parameters']['youngs_modulus']
    assert own['interval_95'][0] < fitted['value'] < own['interval_95'][1]
    assert own['laplace_95'][0] < fitted['value'] < own['laplace_95'][1]
    assert 'Profile likelihood' in (tmp_path / 'out' / 'report.html').read_text()


@pytest.mark.parametrize(
    ('options', 'words'),
    [
        (['--profile', 'density'], "cannot profile 'density': fitted are youngs_modulus"),
        (['--profile', 'youngs_modulus', '--law', 'all'], 'leave out --field and --law all'),
        (['--profile', 'youngs_modulus', '--field'], 'leave out --field and --law all'),
        (
            ['--profile', 'youngs_modulus', '--loss', 'paper'],
            'a whole-image loss has no likelihood',
        ),
    ],
)
def test_impossible_profiles_are_refused(calibrate, options, words):
    ran = calibrate(*options)
    assert ran.code == 2
    assert words in ran.err


def test_open_ends_are_said_in_words():
    def line(low: float, high: float) -> str:
        own = Profile('rest_length', 'm', np.zeros(0), np.zeros(0), low, high, (0.1, 0.2))
        (text,) = profile_lines(type('Result', (), {'profiles': (own,)}))
        return text

    assert 'above 120 mm;' in line(0.12, np.inf)
    assert 'below 120 mm;' in line(-np.inf, 0.12)
    assert 'no limit;' in line(-np.inf, np.inf)
    assert '110 to 120 mm;' in line(0.11, 0.12)
