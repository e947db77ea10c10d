# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A motion's chosen model, refitted with what its mesh and time step cost where it stands."""

from collections.abc import Collection
from dataclasses import replace

from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patch_fits.refit import refit
from diffcal_ros.errors import NotSimulatedError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def refitted_there(hypothesis: Hypothesis) -> Hypothesis:
    """Fit a motion's model on with what mesh and time step cost where it stands.

    Found around the nominal fit, these are of another motion: where the drag of the air hides in
    the damping, nothing rings that a coarse mesh would delay. The effects are there by now: their
    amplitudes are as large as these frames say.

    Args:
        hypothesis: the model.

    Returns:
        The fitted model; the same one where it cannot be simulated again: a state that was
        reached by small load steps is not always found from another one.
    """
    here = hypothesis.fit.coordinates
    names = {name for candidate in hypothesis.added for name in candidate.names}
    model = hypothesis.evaluator.model
    wider = with_own_size(model.parameters, here, names)
    try:
        evaluator = hypothesis.evaluator.of(model.with_parameters(hypothesis.scene, wider))
        evaluator = evaluator.renewed(here)
        return replace(hypothesis, evaluator=evaluator, fit=refit(evaluator, here))
    except NotSimulatedError:
        return hypothesis


def with_own_size(
    parameters: ParameterSet, coordinates: FloatArray, names: Collection[str]
) -> ParameterSet:
    """Return the parameters with amplitudes as large as they are for as usual.

    How large an effect usually is says how likely it is, not how large this one is: a drag five
    times as large would be drawn by a percent or two to none, and count as strained.

    Args:
        parameters: of a model with effects.
        coordinates: where its fit ended, shape (k,).
        names: of the amplitudes.
    """
    wider = []
    for parameter, value in zip(parameters, coordinates, strict=True):
        usual = parameter.quantity.prior_std
        if parameter.name in names and usual is not None:
            size = max(usual, abs(float(value)))
            parameter = replace(parameter, quantity=replace(parameter.quantity, prior_std=size))
        wider.append(parameter)
    return ParameterSet(tuple(wider), parameters.pose_covariances)
