# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Simulators whose effective moduli are fitted: what this package models them by, who is run."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import cast

from diffcal_ros.errors import InputError
from diffcal_ros.export.exported_body import ExportedBody
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# The whole protocol of a simulator that is run: a body and vertices to start from [m], shape
# (V, 3), in; vertices at rest [m], shape (V, 3), out. It raises EquilibriumError where it finds
# none.
Run = Callable[[ExportedBody, FloatArray], FloatArray]

# The same of a motion: a body, vertices where it is let go from rest [m], shape (V, 3), and times
# since then [s], ascending, shape (S,), in; vertices at these times [m], shape (S, V, 3), out. It
# raises MotionError where it finds none.
Swing = Callable[[ExportedBody, FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True)
class Simulator:
    """A simulator of linear tetrahedra.

    Attributes:
        name: as on the command line.
        law: of this package that is nearest to its own.
        kinship: how near, in words.
        package: that is run where it is installed; empty: none is.
        module: here, whose `come_to_rest` is a `Run` and `swing` a `Swing`; empty where none is
            run.
    """

    name: str
    law: str
    kinship: str
    package: str = ''
    module: str = ''


_KNOWN = (
    Simulator(
        'mujoco',
        'st_venant_kirchhoff',
        'the same elements and the same law',
        package='mujoco',
        module='mujoco_run',
    ),
    Simulator(
        'newton',
        'stable_neo_hookean',
        'the same elements and, in `SolverSemiImplicit`, the same law',
        package='newton',
        module='newton_run',
    ),
    Simulator(
        'sofa',
        'st_venant_kirchhoff',
        'the same elements and the same law; the corotational one agrees for small strains',
    ),
    Simulator(
        'physx',
        'st_venant_kirchhoff',
        'linear tetrahedra of this mesh, whose corotational law agrees for small strains; PhysX '
        'may simulate on a mesh of its own, which is then what counts',
    ),
)
SIMULATORS = {own.name: own for own in _KNOWN}


def find_simulator(name: str) -> Simulator:
    """Return a simulator by its name.

    Raises:
        InputError: for a name that is none.
    """
    if name not in SIMULATORS:
        raise InputError(f'simulator is {name!r}: use one of {", ".join(SIMULATORS)}')
    return SIMULATORS[name]


def find_run(simulator: Simulator) -> Run | None:
    """Return how a simulator is run; None where it is not installed or never is."""
    module = _module(simulator)
    return None if module is None else cast(Run, module.come_to_rest)


def find_swing(simulator: Simulator) -> Swing | None:
    """Return how a motion is run; None where the simulator is not installed or never run."""
    module = _module(simulator)
    return None if module is None else cast(Swing, module.swing)


def _module(simulator: Simulator) -> ModuleType | None:
    if not simulator.package or find_spec(simulator.package) is None:
        return None
    return import_module(f'diffcal_ros.export.effective.{simulator.module}')
