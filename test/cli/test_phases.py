# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Commands say what they are doing before it takes long; numbers are looked at before that."""

import pytest


@pytest.mark.slow
def test_simulating_and_filming_are_said(run_cli, write_scene, tmp_path):
    scene = write_scene({'marker': {'dictionary': 'DICT_6X6_250', 'id': 0, 'side': 0.03}})
    options = ('--frames', 1, '--element', 'linear')
    ran = run_cli('simulate', scene, '--out', tmp_path / 'twin', *options)
    assert ran.code == 0, ran.err
    said = [line for line in ran.err.splitlines() if 'note:' not in line]
    assert said == [
        'simulating observation, 192 tetrahedra',
        'filming observation, 1 depth images',
    ]


@pytest.mark.parametrize('place', ['nan', '1e300', 'here'])
@pytest.mark.parametrize('command', ['simulate', 'predict'])
def test_a_camera_must_stand_somewhere(run_cli, write_scene, tmp_path, capsys, command, place):
    options = ('--out', tmp_path / 'out', '--camera-position', place, 0, 1)
    with pytest.raises(SystemExit, match='2'):
        run_cli(command, write_scene(), *options)
    assert f"'{place}' is no coordinate in metres" in capsys.readouterr().err


def test_nobody_films_for_years(run_cli, write_scene, tmp_path):
    ran = run_cli('simulate', write_scene(), '--out', tmp_path / 'out', '--frames', 10**12)
    assert ran.code == 2
    assert '1000000000000 depth frames were asked for: give at most 100000' in ran.err
