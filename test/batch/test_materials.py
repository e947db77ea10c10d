# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From results of bodies to materials, their comparison, the table and the page."""

import csv
import json

from diffcal_ros.batch.materials import compare_materials, find_materials, fit_materials
from diffcal_ros.batch.summary import JSON_FILE, PAGE_FILE, summarise, TABLE_FILE, write_summary
from diffcal_ros.report.pages.batch_page import write_batch_page
from diffcal_ros.report.tables.batch_text import batch_lines
import numpy as np
import pytest
from scipy.stats import ttest_ind

_SOFT, _HARD = 60e3, 140e3
_SPREAD, _ERROR = 0.05, 0.02


@pytest.fixture
def bodies(fitted, random):
    """Ten bodies of each of two materials; one of the soft ones was mixed up."""
    made = []
    for number in range(10):
        for material, mean in (('soft', _SOFT), ('hard', _HARD)):
            value = mean * np.exp(random.normal(scale=np.hypot(_SPREAD, _ERROR)))
            made.append(fitted(f'{material}_{number}', material, value, _ERROR * value))
    made.append(fitted('mixed_up', 'soft', 1.8 * _SOFT, 1.8 * _ERROR * _SOFT))
    made.append(fitted('off', 'soft', 9.0 * _SOFT, 1.0, outcome='model_disagrees'))
    return made


def test_materials_are_fitted_without_outliers_and_without_doubtful_fits(bodies) -> None:
    hard, soft = fit_materials(bodies)
    assert (hard.material, soft.material) == ('hard', 'soft')
    assert [name for name, out in zip(soft.bodies, soft.is_outlier, strict=True) if out] == [
        'mixed_up'
    ]
    assert 'off' not in soft.bodies
    for fit, truth in ((hard, _HARD), (soft, _SOFT)):
        low, high = fit.as_dict()['interval_95']
        assert low < truth < high
        low, high = fit.as_dict()['spread_95']
        assert low < _SPREAD * truth < high


def test_a_difference_is_as_clear_as_a_test_without_errors_says(fitted, random) -> None:
    # Where bodies know themselves exactly, this is Welch's test of their logarithms.
    values = {'one': random.normal(11.0, 0.1, 8), 'two': random.normal(11.1, 0.2, 12)}
    made = [
        fitted(f'{material}_{n}', material, float(np.exp(value)), 1e-7 * float(np.exp(value)))
        for material, own in values.items()
        for n, value in enumerate(own)
    ]
    (compared,) = compare_materials(fit_materials(made))
    welch = ttest_ind(values['two'], values['one'], equal_var=False)
    assert compared.p == pytest.approx(welch.pvalue, rel=1e-4)
    assert compared.difference == pytest.approx(np.mean(values['two']) - np.mean(values['one']))


def test_of_several_pairs_each_is_judged_with_the_others(fitted, random) -> None:
    def pairs(materials):
        made = [
            fitted(f'{material}_{n}', material, 1e5 * (1.0 + 0.1 * shift + 0.05 * n), 1e3)
            for shift, material in enumerate(materials)
            for n in range(4)
        ]
        return {own.materials: own.p for own in compare_materials(fit_materials(made))}

    alone, together = pairs('ab'), pairs('abc')
    assert together[('a', 'c')] < together[('a', 'b')]
    assert together[('a', 'b')] > alone[('a', 'b')]


def test_bodies_that_share_a_material_are_found_whatever_is_stated(bodies) -> None:
    (found,) = find_materials(bodies)
    assert len(found.means) == 2
    assert {found.places[f'hard_{n}'] for n in range(10)} == {1}
    assert {found.places[f'soft_{n}'] for n in range(10)} == {0}


def test_what_all_meshes_share_stays_in_the_mean(fitted) -> None:
    made = [fitted(f'b{n}', 'm', 1e5 + 100.0 * n, 1e3, mesh_error=5e3) for n in range(9)]
    (fit,) = fit_materials(made)
    assert fit.as_dict()['mean_error'] == pytest.approx(5e3, rel=0.02)
    assert fit.errors == pytest.approx(np.full(9, 1e3))


def test_regions_may_be_of_different_materials(fitted) -> None:
    stated = {'tip': 'soft', 'root': 'hard'}
    made = [fitted('a', stated, 5e4, 1e3, parameter='youngs_modulus.tip')]
    made.append(fitted('b', {'': 'soft'}, 5e4, 1e3, parameter='youngs_modulus.body'))
    made.append(fitted('c', stated, 5e4, 1e3))
    assert [value.material for body in made for value in body.material_values()] == [
        'soft',
        'soft',
        '',
    ]


def test_one_table_one_page_and_everything(bodies, tmp_path) -> None:
    summary = summarise(bodies)
    write_summary(summary, tmp_path)
    write_batch_page(tmp_path, 'two materials', summary)
    with (tmp_path / TABLE_FILE).open(newline='') as file:
        table = {row['body']: row for row in csv.DictReader(file)}
    assert len(table) == len(bodies)
    assert table['mixed_up']['is_outlier'] == 'True'
    assert float(table['off']['youngs_modulus.fine_mesh_value']) == 9.0 * _SOFT
    content = json.loads((tmp_path / JSON_FILE).read_text())
    assert content['materials'][1]['outliers'] == ['mixed_up']
    assert set(content['materials'][1]['offsets']) == {f'soft_{n}' for n in range(10)}
    page = (tmp_path / PAGE_FILE).read_text()
    assert page.count('<img') == 1
    assert 'hard and soft differ' in page
    assert 'href="bodies/mixed_up/report.html"' in page
    lines = '\n'.join(batch_lines(summary, tmp_path, 3))
    assert '22 bodies: 21 converged, 1 model disagrees (19 were done before)' in lines
    assert 'left out as outliers: mixed_up' in lines
