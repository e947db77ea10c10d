# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fits of the public captures against the figures that are known of them."""

from dataclasses import replace
from functools import cache
from pathlib import Path

from diffcal_ros.calibration.calibrate import calibrate, Calibration
from diffcal_ros.calibration.field.fit import fit_field
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.material import LameConvention
import numpy as np
import pytest
from support.captures import load_case
from support.fields import area_under_curve

_QUICK = CalibrationSettings(with_mesh_error=False)
_OFFSET_AND_MODULUS = ('youngs_modulus', 'rigid_offset')


@cache
def _fit(data: Path, case: str) -> CalibrationResult:
    scene, observations = load_case(data, case, 'estimated')
    return calibrate(replace(scene, fit=_OFFSET_AND_MODULUS), observations, _QUICK)


def test_paper_mode_finds_the_papers_minimum(diffcal_data: Path) -> None:
    scene, observations = load_case(diffcal_data, 'h_e_c', 'stored')
    scene = replace(scene, element=Element.LINEAR, convention=LameConvention.PAPER)
    result = calibrate(
        scene, observations, CalibrationSettings(fit=('youngs_modulus',), loss='paper')
    )
    assert 55e3 <= result['youngs_modulus'].value <= 62e3
    assert result.history[-1].loss <= 196.6e3


def test_default_mode_closes_the_gap_on_the_cantilever(diffcal_data: Path) -> None:
    result = _fit(diffcal_data, 'h_e_c')
    assert result.gap_end.median <= 1.5e-3
    assert result.gap_end.coverage >= 0.97


@pytest.mark.slow
def test_default_mode_closes_the_gap_on_the_spine(diffcal_data: Path) -> None:
    result = _fit(diffcal_data, 'h_e_s')
    assert result.gap_end.median <= 2.5e-3
    assert result.gap_end.coverage >= 0.95


def test_one_silicone_has_one_modulus(diffcal_data: Path) -> None:
    cantilever = _fit(diffcal_data, 'h_e_c')['youngs_modulus'].value
    spine = _fit(diffcal_data, 'h_e_s')['youngs_modulus'].value
    assert 1.0 / 1.4 <= spine / cantilever <= 1.4


@pytest.mark.slow
def test_ten_starts_end_at_one_modulus(diffcal_data: Path) -> None:
    scene, observations = load_case(diffcal_data, 'h_e_c', 'estimated')
    (region,) = scene.regions
    random = np.random.default_rng(7)
    moduli, iterations = [], []
    for share in random.uniform(-0.45, 0.45, size=10):
        start = replace(region.youngs_modulus, start=132e3 * (1.0 + share))
        moved = replace(scene, regions=(replace(region, youngs_modulus=start),))
        result = calibrate(moved, observations, _QUICK)
        moduli.append(result['youngs_modulus'].value)
        iterations.append(result.iterations)
    assert np.ptp(moduli) <= 0.01 * np.mean(moduli)
    assert max(iterations) <= 8


@pytest.mark.slow
@pytest.mark.parametrize('case', ['h_em_c', 't_em_c'])
def test_two_region_captures_say_that_something_is_left(diffcal_data: Path, case: str) -> None:
    result = _fit(diffcal_data, case)
    assert result.gap_end.median < result.gap_start.median
    assert not np.isnan(result.gap_end.coverage)
    assert result.warnings


@pytest.mark.slow
def test_a_field_finds_the_two_silicones_of_a_beam(diffcal_data: Path) -> None:
    scene, observations = load_case(diffcal_data, 'h_em_c_tetwise', 'estimated')
    calibration = Calibration(scene, observations, replace(_QUICK, fit=_OFFSET_AND_MODULUS))
    field = fit_field(calibration, calibration.run())
    is_stiff = scene.mesh.centroids[:, 0] < 0.0
    assert area_under_curve(field.youngs_modulus, is_stiff) >= 0.95
    # Two moduli leave 0.525 mm on 69 % of the body, for a step of depth that no modulus explains.
    assert field.result.gap_end.median <= 0.53e-3
    assert field.result.gap_end.coverage >= 0.69
