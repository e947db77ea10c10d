# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal calibrate --for`: moduli that other simulators need."""

import argparse
from dataclasses import replace
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from diffcal_ros.calibration.calibrate import Calibration
    from diffcal_ros.calibration.field.fit import FieldFit
    from diffcal_ros.calibration.results.result import CalibrationResult
    from diffcal_ros.cli.progress import Progress

# Named here, for `--help` must be quick; a test compares them with the simulators that are there.
SIMULATORS = ('mujoco', 'newton', 'sofa', 'physx')


def add_effective_option(group: Any) -> None:
    """Add the option."""
    group.add_argument(
        '--for',
        dest='simulators',
        choices=SIMULATORS,
        nargs='+',
        action='extend',
        default=[],
        help="also fit the modulus that a simulator's linear elements need on this mesh, and for "
        'a body that is let go its damping, with the gap that it leaves; `diffcal export` takes '
        'them. mujoco and newton themselves are run where they are installed, the others are '
        'modelled',
    )


def fit_asked_effective(
    args: argparse.Namespace,
    fitted_scene: 'Path',
    calibration: 'Calibration',
    result: 'CalibrationResult',
    field: 'FieldFit | None',
    progress: 'Progress',
) -> 'CalibrationResult':
    """Return the result with what each simulator needs.

    Raises:
        InputError: when no modulus was fitted, or linear elements cannot carry the body.
    """
    from diffcal_ros.calibration.calibrate import with_details
    from diffcal_ros.export.effective.fit import fit_effective
    from diffcal_ros.export.effective.simulators import find_simulator
    from diffcal_ros.report.tables.effective_table import EFFECTIVE
    from diffcal_ros.scene.load import load_scene
    from diffcal_ros.scene.save import save_fitted_scene

    scene = calibration.scene
    if field is not None:
        scene = replace(scene, relative_modulus=field.relative_modulus)
    save_fitted_scene(scene, fitted_scene, result.values())
    fitted = load_scene(fitted_scene)
    fits = {
        name: fit_effective(
            calibration, result, fitted, find_simulator(name), report=progress.say
        ).as_dict()
        for name in dict.fromkeys(args.simulators)
    }
    return with_details(result, **{EFFECTIVE: fits})
