# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Experiments are read from YAML, and wrong ones are refused."""

from diffcal_ros.errors import SceneError
from diffcal_ros.reproduction.row import load_row, merged, row_names
import pytest
from support.small_row import ROW
import yaml


@pytest.mark.parametrize('name', row_names())
def test_every_installed_experiment_is_sound(name) -> None:
    row = load_row(name)
    assert row.title
    names = [variant.name for variant in row.variants]
    assert len(set(names)) == len(names)
    for variant in row.variants:
        for low, high in variant.start.values():
            assert low < high


def test_variants_change_what_the_row_says() -> None:
    base = {'scene': {'mesh': {'unit': 'cm', 'element': 'linear'}, 'fit': ['a']}, 'pose': 'stored'}
    changed = merged(base, {'scene': {'mesh': {'element': 'quadratic'}, 'fit': None}})
    assert changed == {
        'scene': {'mesh': {'unit': 'cm', 'element': 'quadratic'}},
        'pose': 'stored',
    }
    assert base['scene']['fit'] == ['a']


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'colour': 1}, "has 'colour', which is not known: use case"),
        ({'scene_file': None}, 'needs a `case` of the public data set, a `scene_file`, or'),
        ({'simulate': None}, 'nothing was filmed: add `simulate`'),
        ({'modulus_field': 'yes'}, "modulus_field is 'yes': use true or false"),
        ({'pose': 'guessed'}, "pose is 'guessed': use estimated or stored"),
    ],
)
def test_wrong_experiments_are_refused(row_file, change, message) -> None:
    row_file.write_text(yaml.safe_dump(merged(ROW, change)))
    with pytest.raises(SceneError, match=message):
        load_row(str(row_file))


def test_an_unknown_experiment_is_refused_with_those_that_are_known() -> None:
    with pytest.raises(SceneError, match=r"no experiment 'h_x_y': .* h_e_c"):
        load_row('h_x_y')
