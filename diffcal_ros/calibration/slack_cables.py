# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A slack cable moves nothing: a fit starts where it is just taut, and may end not knowing."""

from diffcal_ros.calibration.forward_model import ForwardModel
from diffcal_ros.calibration.parameters import Kind, ParameterSet
from diffcal_ros.fem.cable import CableTerm
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Of the width over which tension sets in: the cable has its full stiffness there.
_TAUT = 2.0


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
    places = parameters.find(Kind.REST_LENGTH)
    if not places:
        return start, ()
    coordinates, notes = start.copy(), []
    lower, upper = parameters.bounds()
    for place in places:
        model.views(coordinates)
        number = parameters.parameters[place].target
        excess = min(
            _slack(posture.body.cables[number], posture.positions(0))
            for posture in model.bodies.values()
        )
        if excess <= 0.0:
            continue
        cable = model.scene.cables[number]
        begun = float(coordinates[place])
        taut = begun - excess - _TAUT * _smoothing(model, number)
        coordinates[place] = np.clip(taut, lower[place], upper[place])
        notes.append(
            f'cable {cable.name} was slack at its start of {1e3 * begun:.4g} mm: the fit started '
            f'where it is just taut, {1e3 * coordinates[place]:.4g} mm'
        )
    return coordinates, tuple(notes)


def barely_pulling(
    model: ForwardModel, parameters: ParameterSet, coordinates: FloatArray
) -> tuple[str, ...]:
    """Name fitted rest lengths of cables that pull in no posture, or just begin to.

    Any longer rest length would fit as well.
    """
    places = parameters.find(Kind.REST_LENGTH)
    if not places:
        return ()
    model.views(coordinates)
    names = []
    for place in places:
        parameter = parameters.parameters[place]
        loose = [
            _slack(posture.body.cables[parameter.target], posture.positions(0))
            for posture in model.bodies.values()
        ]
        if min(loose) > -_smoothing(model, parameter.target):
            names.append(parameter.name)
    return tuple(names)


def _slack(cable: CableTerm, positions: FloatArray) -> float:
    """Return by how much a cable is too long to pull [m]; negative where it pulls."""
    return cable.state.rest_length - 0.5 * cable.smoothing - cable.length(positions)


def _smoothing(model: ForwardModel, number: int) -> float:
    posture = next(iter(model.bodies.values()))
    return posture.body.cables[number].smoothing
