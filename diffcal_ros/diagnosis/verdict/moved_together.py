# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether body and clamp were found elsewhere together, with the fixture around them.

A camera on a stand that leans with the rig's heavy side sees all of a rig elsewhere, and elsewhere
in each pose: in the object's frame, by the same. To the body that is a clamp that was displaced.
The fixture tells: where it has to follow, the body sits in its clamp as the scene says.
"""

from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patches.rigid_reference import fixture_offset
from diffcal_ros.effects.clamp_offset import ClampOffset
from diffcal_ros.effects.rigid import twist_of
from diffcal_ros.rigid_motion import moved
import numpy as np

# Of a displaced clamp so much at least is a displacement beside the fixture.
_LEAST_BESIDE = 0.5


def moves_with_fixture(hypothesis: Hypothesis) -> bool:
    """Tell whether the fixture was moved by most of what a clamp was displaced by."""
    names = {candidate.identifier for candidate in hypothesis.added}
    model, coordinates = hypothesis.evaluator.model, hypothesis.fit.coordinates
    fixture = model.scene.fixture
    has_offset = any(one.kind is Kind.FIXTURE_OFFSET for one in model.parameters)
    if ClampOffset.identifier not in names or fixture is None or not has_offset:
        return False
    points = fixture.positions
    twist = twist_of(model.effects.amplitudes(coordinates)[ClampOffset.identifier])
    offset = fixture_offset(hypothesis.fit.parameters, coordinates)
    clamp = moved(points, twist, model.effects.object_axes(0).center) - points
    beside = clamp - (moved(points, offset, points.mean(axis=0)) - points)
    return bool(np.linalg.norm(beside) < _LEAST_BESIDE * np.linalg.norm(clamp))
