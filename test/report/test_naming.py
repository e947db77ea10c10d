# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Numbers, units and names as people read them, and the table for a terminal."""

from dataclasses import replace
import math

from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.report.naming import short_values, shown, title
from diffcal_ros.report.tables.result_table import result_text
import pytest

NAN = math.nan


@pytest.mark.parametrize(
    ('value', 'error', 'unit', 'text'),
    [
        (123456.0, 7890.0, 'Pa', '123.5 +- 7.9 kPa'),
        (123456.0, 99.6, 'Pa', '123.46 +- 0.10 kPa'),
        (5e6, 1.3e6, 'Pa', '5000 +- 1300 kPa'),
        (0.00123, 0.0004, 'm', '1.23 +- 0.40 mm'),
        (-0.0000004, 0.0004, 'm', '0.00 +- 0.40 mm'),
        (math.pi / 2, 0.01, 'rad', '90.00 +- 0.57 deg'),
        (0.45, NAN, '1', '0.45'),
        (1e5, 0.0, 'Pa', '100 kPa'),
    ],
)
def test_two_digits_of_the_error_decide(value, error, unit, text):
    assert shown(value, error, unit).text() == text


def test_titles():
    assert title('youngs_modulus.tip') == "Young's modulus, tip"
    assert title('rigid_offset.rx') == 'rigid offset, turn about x'
    assert title('camera_pose.0.ry') == 'camera pose 1, turn about y'
    assert title('something_new') == 'something new'


def test_a_line_of_progress_names_regions_and_the_length_of_the_offset():
    values = {
        'youngs_modulus.tip': 1.5e5,
        'rigid_offset.x': 0.003,
        'rigid_offset.y': 0.004,
        'rigid_offset.z': 0.0,
        'rigid_offset.rx': 0.5,
    }
    assert short_values(values) == 'E of tip 150.0 kPa, offset 5.0 mm'


def test_the_terminal_table_tells_values_gap_outcome_and_warnings(fitted):
    _, result = fitted
    warned = replace(result, warnings=('a word ' * 30,))
    lines = result_text('beam', warned).splitlines()
    assert lines[0] == 'beam: converged'
    rows = [line.split('  ')[0] for line in lines]
    for parameter in result.parameters:
        assert (title(parameter.name) in rows) != parameter.is_nuisance
    assert any(line.startswith('gap         median ') for line in lines)
    assert sum(line.startswith('warning: a word') for line in lines) == 1
    assert max(map(len, lines)) <= 100


def test_the_body_and_the_model_that_needs_another_modulus_are_told_apart(fitted):
    _, result = fitted
    modulus = replace(
        result['youngs_modulus'],
        value=231.2e3,
        std_error=15.01e3,
        mesh_error=15e3,
        fine_value=244.3e3,
        interval_95=(239.4e3, 249.4e3),
    )
    others = [p for p in result.parameters if p.name != 'youngs_modulus']
    text = result_text('beam', replace(result, parameters=(modulus, *others)))
    (row,) = [line for line in text.splitlines() if line.startswith("Young's modulus")]
    # The mesh's part is no error of what this mesh needs: sqrt(15.01^2 - 15^2) = 0.55.
    assert '231.20 +- 0.55 kPa' in row
    assert '239.4 to 249.4 kPa' in row
    assert '231.2 kPa makes this mesh right, the body itself has 244.3 kPa' in text
    assert 'makes this mesh right' not in result_text(
        'beam', replace(result, parameters=(replace(modulus, fine_value=231.2e3), *others))
    )


def test_a_gap_that_nothing_was_found_for_is_a_dash(fitted):
    nothing = Gap(NAN, NAN, 0.0, 0)
    text = result_text('beam', replace(fitted[1], gap_start=nothing))
    assert 'gap         median - -> ' in text
    assert 'nan' not in text
