# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A slack cable moves nothing: a fit starts where it is just taut, and may end not knowing."""

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameters import Kind, ParameterSet
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.fem.cable import CableTerm
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Of the width over which tension sets in: the cable has its full stiffness there.
_TAUT = 2.0
_OUT_OF_THE_WAY = 20.0
_AS_LIKELY = 0.5 * 1.96**2


def taut_start(
    model: ForwardModel, parameters: ParameterSet, start: FloatArray
) -> tuple[FloatArray, tuple[str, ...]]:
    """Shorten fitted cables that are slack in every posture; say which and how far.

    Args:
        model: of the fit.
        parameters: of the fit.
        start: coordinates, shape (k,).

    Returns:
        Coordinates to start from, and a sentence for each cable that was slack.

    Raises:
        EquilibriumError: when the start has no equilibrium.
    """
    indices = parameters.find(Kind.REST_LENGTH)
    if not indices:
        return start, ()
    coordinates, notes = start.copy(), []
    lower, upper = parameters.bounds()
    for index in indices:
        model.views(coordinates)
        number = parameters.parameters[index].target
        excess = min(
            _slack(posture.body.cables[number], posture.positions(0))
            for posture in model.bodies.values()
        )
        if excess <= 0.0:
            continue
        cable = model.scene.cables[number]
        begun = float(coordinates[index])
        taut = begun - excess - _TAUT * _smoothing(model, number)
        coordinates[index] = np.clip(taut, lower[index], upper[index])
        notes.append(
            f'cable {cable.name} was slack at its start of {1e3 * begun:.4g} mm: the fit started '
            f'where it is just taut, {1e3 * coordinates[index]:.4g} mm'
        )
    return coordinates, tuple(notes)


def barely_pulling(
    objective: RobustObjective, parameters: ParameterSet, coordinates: FloatArray
) -> tuple[str, ...]:
    """Name fitted rest lengths of cables that might as well be slack.

    Those are cables that pull in no posture by more than the onset of tension, and without which
    the data are as likely, by the ratio of likelihoods at 95 %. Any longer rest length would do.
    """
    model, names = objective.model, []
    for index in parameters.find(Kind.REST_LENGTH):
        model.views(coordinates)
        parameter = parameters.parameters[index]
        smoothing = _smoothing(model, parameter.target)
        loose = min(
            _slack(posture.body.cables[parameter.target], posture.positions(0))
            for posture in model.bodies.values()
        )
        if loose > 0.0:
            names.append(parameter.name)
        elif loose > -smoothing:
            without = coordinates.copy()
            without[index] += _OUT_OF_THE_WAY * smoothing
            if objective.cost(without) - objective.cost(coordinates) < _AS_LIKELY:
                names.append(parameter.name)
    return tuple(names)


def _slack(cable: CableTerm, positions: FloatArray) -> float:
    """Return by how much a cable is too long to pull [m]; negative where it pulls."""
    return cable.state.rest_length - 0.5 * cable.smoothing - cable.length(positions)


def _smoothing(model: ForwardModel, number: int) -> float:
    posture = next(iter(model.bodies.values()))
    return posture.body.cables[number].smoothing
