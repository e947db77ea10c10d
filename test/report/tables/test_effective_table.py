# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Both moduli stand side by side, in the terminal and in the report."""

from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.export.effective.effective_fit import EffectiveFit, EffectiveValue
from diffcal_ros.report.tables.effective_table import effective_lines, effective_section
import numpy as np

NOWHERE = Gap(float('nan'), float('nan'), 0.0, 0)
FOUND = EffectiveFit(
    simulator='mujoco',
    way='mujoco itself',
    is_run=True,
    moduli=(
        EffectiveValue('youngs_modulus.tip', 60e3, 3e3, 41e3, 1.5e3, 'Pa'),
        EffectiveValue('youngs_modulus.root', 90e3, 4e3, 71e3, 2e3, 'Pa'),
    ),
    dampings=(EffectiveValue('damping', 151.0, 4.0, 120.0, 3.0, 'Pa s'),),
    poissons_ratios={'tip': (0.49, 0.2), 'root': (0.4, 0.2)},
    gap_material=NOWHERE,
    gap_effective=Gap(0.00087, 0.0016, 0.97, 100),
    gap_own=Gap(0.0002, 0.0003, 0.99, 100),
    off_material=float('nan'),
    off_effective=0.0035,
    outcome=Outcome.CONVERGED,
    notes=('it rained < 2 mm',),
)


def result(**details):
    gap = Gap(0.0002, 0.0003, 0.99, 100)
    return CalibrationResult(
        Outcome.CONVERGED, (), gap, gap, 'robust', (), np.zeros((0, 0)), details=details
    )


def test_a_line_for_the_material_and_one_for_the_simulator():
    lines = effective_lines(result(effective={'mujoco': FOUND.as_dict()}))
    text = '\n'.join(lines)
    material, effective, own = lines[2:5]
    assert material.startswith("mujoco     the material's")
    assert 'no equilibrium' in material
    assert 'tip 41.0 +- 1.5 kPa, root 71.0 +- 2.0 kPa' in effective
    assert '0.87 / 1.6 mm' in effective
    assert effective.endswith('3.5 mm')
    assert '0.2 / 0.3 mm' in own
    assert 'note: it rained < 2 mm' in text
    assert 'damping 120.0 +- 3.0 Pa s for its swings, the material has 151.0 +- 4.0 Pa s' in text


def test_the_report_has_the_same_and_is_escaped():
    page = effective_section(result(effective={'mujoco': FOUND.as_dict()}))
    assert '<h2>In other simulators</h2>' in page
    assert '3.5 mm' in page
    assert 'it rained &lt; 2 mm' in page


def test_without_simulators_nothing_is_said():
    assert effective_lines(result()) == []
    assert effective_section(result()) == ''
