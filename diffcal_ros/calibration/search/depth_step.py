# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a fit leaves half a body out: may its camera read one of two materials too far?

A LIDAR looks into a translucent material and reads it centimetres behind its surface. A robust fit
takes pixels that are so far off for something else; it then fits the rest and leaves a part of the
body unexplained.
"""

from collections.abc import Callable
from dataclasses import replace

from diffcal_ros.calibration.contest import Contest
from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.seen_fit import SeenFit
from diffcal_ros.effects.registry import seen_boundary
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def may_have_step(scene: Scene, parameters: ParameterSet) -> bool:
    """Tell whether a body is of several materials, and nothing is said of how they are read."""
    effect = seen_boundary()
    is_known = effect.identifier in scene.effects or any(
        own.effect == effect.identifier for own in parameters
    )
    return len(scene.regions) > 1 and not is_known


def contest_with_step(
    contest: Contest, are_same: Callable[[FloatArray, FloatArray], bool]
) -> Contest | None:
    """Fit again from where fits ended, the step of depth that their residuals show in the model.

    Args:
        contest: of fits without it.
        are_same: tells whether a fit without it would hardly tell two places apart.

    Returns:
        The fits with the step; None: no fit shows one.
    """
    model = _with_step(contest.objective.model)
    found = Contest(contest.objective.of(model))

    def is_one_place(one: FloatArray, other: FloatArray) -> bool:
        return are_same(without_step(model.parameters, one), without_step(model.parameters, other))

    for entry in contest.entries:
        for start in _starts(contest.objective, entry.minimum.coordinates, model.parameters):
            if not found.is_known(start, is_one_place):
                # Under wide scales a prior would draw the step to nothing; noise is known by now.
                found.challenge(start, entry.scales)
    return found if found.entries else None


def without_step(parameters: ParameterSet, coordinates: FloatArray) -> FloatArray:
    """Return coordinates of a fit with the step as those of the one without, shape (k - 1,)."""
    return coordinates[~_is_step(parameters)]


def step_note(before: Contest, after: Contest) -> str:
    """Say what was added to the model, and why.

    Args:
        before: fits without the step.
        after: fits with it, see `contest_with_step`.
    """
    first, *others = [region.name for region in after.objective.model.scene.regions]
    at = after.best.minimum.coordinates
    parameters = after.objective.parameters
    (place,) = np.flatnonzero(_is_step(parameters))
    step = float(at[place])
    without, with_it = (
        one.objective.under(one.best.scales).gap(one.best.minimum.coordinates)
        for one in (before, after)
    )
    return (
        f'the depth camera reads {" and ".join(others)} {1e3 * abs(step):.1f} mm too '
        f'{"far" if step > 0.0 else "near"} beside {first}: the fit has that in its model '
        f'({parameters.names[place]}); so {with_it.coverage:.0%} of the rendered '
        f'body is found in the image, with a median gap of {1e3 * with_it.median:.2f} mm, and '
        f'{without.coverage:.0%} with {1e3 * without.median:.2f} mm without'
    )


def _starts(
    objective: RobustObjective, there: FloatArray, parameters: ParameterSet
) -> list[FloatArray]:
    """Return where a fit ended, with the steps that its residuals show, shape (k,) each."""
    effect = seen_boundary()
    (name,) = map(effect.amplitude_name, (part.name for part in effect.components))
    ended = dict(zip(objective.parameters.names, there.tolist(), strict=True))
    proposed = [start for start in effect.starts(SeenFit(objective, there), None) if name in start]
    lower, upper = parameters.bounds()
    coordinates = [[{**ended, **start}[own] for own in parameters.names] for start in proposed]
    return [np.clip(own, lower, upper) for own in coordinates]


def _with_step(model: ForwardModel) -> ForwardModel:
    """Return the model with the step of depth, where a scene that names it would have it."""
    effect = seen_boundary()
    names = effect.fit_names(tuple(part.name for part in effect.components))
    scene = replace(model.scene, fit=(*model.scene.fit, *names))
    (added,) = make_parameters(scene, names, with_edge_bias=False)
    known = list(model.parameters)
    known.insert(sum(not own.is_nuisance for own in known), added)
    return model.with_parameters(scene, replace(model.parameters, parameters=tuple(known)))


def _is_step(parameters: ParameterSet) -> BoolArray:
    """Tell which parameter is the step, shape (k,)."""
    identifier = seen_boundary().identifier
    return np.array([own.effect == identifier for own in parameters])
