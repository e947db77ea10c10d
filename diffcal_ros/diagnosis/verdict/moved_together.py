# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether body and clamp were found elsewhere together, with the fixture around them.

A camera on a stand that leans with the rig's heavy side sees all of a rig elsewhere, and elsewhere
in each pose: in the object's frame, by the same. To the body that is a clamp that was displaced.
The fixture tells: where it has to follow, the body sits in its clamp as the scene says.
"""

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patches.rigid_reference import fixture_offset
from diffcal_ros.effects.effect import Effect
from diffcal_ros.rigid_motion import moved
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Of a displaced clamp so much at least is a displacement beside the fixture.
_LEAST_BESIDE = 0.5


def words_with_fixture(hypothesis: Hypothesis) -> str:
    """Say how far a model's fixture, and what it holds, is from where the scene says it is."""
    offset = fixture_offset(hypothesis.fit.parameters, hypothesis.fit.coordinates)
    shift, turn = (float(np.linalg.norm(part)) for part in (offset[:3], offset[3:]))
    x, y, z = 1e3 * offset[:3]
    return (
        f'{1e3 * shift:.1f} mm ({x:.1f}, {y:.1f}, {z:.1f} along the axes of the object) and '
        f'{np.degrees(turn):.1f} degrees'
    )


def class_with_fixture(hypothesis: Hypothesis) -> str | None:
    """Return the class of what moved the fixture by most of what a clamp was displaced by.

    None where no effect displaces one, the scene states no fixture, or that stayed.
    """
    model, coordinates = hypothesis.evaluator.model, hypothesis.fit.coordinates
    fixture = model.scene.fixture
    if fixture is None or all(one.kind is not Kind.FIXTURE_OFFSET for one in model.parameters):
        return None
    points = fixture.positions
    offset = fixture_offset(hypothesis.fit.parameters, coordinates)
    by_fixture = moved(points, offset, points.mean(axis=0)) - points
    for added in hypothesis.added:
        if not added.effect.class_with_fixture:
            continue
        by_clamp = _displaced(model, coordinates, added.effect, points)
        if np.linalg.norm(by_clamp - by_fixture) < _LEAST_BESIDE * np.linalg.norm(by_clamp):
            return added.effect.class_with_fixture
    return None


def _displaced(
    model: ForwardModel, coordinates: FloatArray, effect: Effect, points: FloatArray
) -> FloatArray:
    """Return how far an effect displaces points in each posture [m], shape (S, n, 3).

    What is clamped anew is elsewhere in each: what that has in common may be next to nothing, and
    within what is known of the fixture.
    """
    effects = model.effects
    return np.array(
        [
            effect.displaced(
                points,
                effects.amplitudes(coordinates, posture)[effect.identifier],
                effects.object_axes(posture),
            )
            - points
            for posture in sorted(model.bodies)
        ]
    )
