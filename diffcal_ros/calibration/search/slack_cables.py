# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A slack cable moves nothing: a fit starts where it is just taut, and may end not knowing."""

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameters import Kind, ParameterSet
from diffcal_ros.calibration.residuals.objective import RobustObjective
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
        number = parameters.parameters[index].target
        excess = _slack(model, number, coordinates)
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
        parameter = parameters.parameters[index]
        smoothing = _smoothing(model, parameter.target)
        loose = _slack(model, parameter.target, coordinates)
        if loose > 0.0:
            names.append(parameter.name)
        elif loose > -smoothing:
            without = coordinates.copy()
            without[index] += _OUT_OF_THE_WAY * smoothing
            if objective.cost(without) - objective.cost(coordinates) < _AS_LIKELY:
                names.append(parameter.name)
    return tuple(names)


def _slack(model: ForwardModel, number: int, coordinates: FloatArray) -> float:
    """Return by how much a cable is too long to pull in any posture [m]; negative: it pulls."""
    return min(
        states.inputs.conditions.cables[number].rest_length
        - 0.5 * _smoothing(model, number)
        - model.bodies[index].body.cables[number].length(states.positions[0])
        for index, states in model.at(coordinates).states.items()
    )


def _smoothing(model: ForwardModel, number: int) -> float:
    posture = next(iter(model.bodies.values()))
    return posture.body.cables[number].smoothing
