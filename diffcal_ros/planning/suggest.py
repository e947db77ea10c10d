# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rank what could be recorded next by how much it would tell about the parameters."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.expected_information import Candidate, Known
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.calibration.residuals.residual_scales import Scale, Scales
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import NotSimulatedError, SceneError
from diffcal_ros.planning.candidates import make_candidates, Refused
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.synthetic.posed_body import pose_body
from diffcal_ros.synthetic.viewpoint import COLOR_CAMERA, default_view, DEPTH_CAMERA
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# What a depth camera's structured error on a soft body is like after a good fit; the order of
# candidates hardly depends on it.
ASSUMED_NOISE = 0.0005  # [m]
ASSUMED_LENGTH = 10.0  # over which residuals say the same [px]
# And how well a marker's pose is known.
_POSE_STD = np.array([5e-4] * 3 + [np.deg2rad(0.3)] * 3)
_RIG = (Kind.RIGID_OFFSET, Kind.CAMERA_POSE, Kind.EDGE_BIAS)


@dataclass(frozen=True)
class Expected:
    """Standard errors of what is asked for.

    Attributes:
        name: of the candidate; `now` without one.
        words: what to do.
        errors: by parameter, in its unit.
        bits: information gained on all of them together.
    """

    name: str
    words: str
    errors: dict[str, float]
    bits: float


@dataclass(frozen=True)
class Suggestion:
    """What to record next.

    Attributes:
        values: of the parameters that are asked for, by name, SI.
        units: of them, SI.
        now: what the scene's own observations tell.
        ranked: candidates, the best first.
        refused: those that cannot be made.
    """

    values: dict[str, float]
    units: dict[str, str]
    now: Expected
    ranked: tuple[Expected, ...]
    refused: tuple[Refused, ...]


def suggest(scene: Scene, *, fit: Sequence[str] | None = None, device: str = 'cpu') -> Suggestion:
    """Rank candidates around a scene's start values, such as those of a fitted scene.

    Args:
        scene: its observations count as recorded already; bodies at rest only.
        fit: parameters; default: the scene's.
        device: Warp device.

    Raises:
        SceneError: for a scene with motion, or one without a parameter of the body to fit.
    """
    if any(setup.motion is not None for setup in scene.observations):
        raise SceneError(
            'suggestions are made for bodies at rest: take the observations with `motion` out'
        )
    parameters = make_parameters(scene, fit)
    asked = [index for index, p in enumerate(parameters) if p.kind not in _RIG]
    if not asked:
        raise SceneError('nothing of the body is fitted: name a parameter of it, as in --fit')
    scale = Scale(width=2.385 * ASSUMED_NOISE, noise=ASSUMED_NOISE, correlation=ASSUMED_LENGTH)
    nothing = np.zeros((len(parameters), len(parameters)))
    known = Known(scene, parameters, parameters.start(), Scales(scale, scale), nothing, nothing)
    views = [_as_recorded(scene, setup) for setup in scene.observations]
    try:
        for view, _ in views:
            known = known.with_candidate(view, device=device)
    except NotSimulatedError as error:
        raise SceneError(f'the scene itself cannot be simulated: {error}') from error
    candidates, refused = make_candidates(*views[0], scene.marker)
    found = []
    for candidate in candidates:
        try:
            found.append(_expected(candidate, known, known.with_candidate(candidate), asked))
        except NotSimulatedError as error:
            refused.append(Refused(candidate.words, str(error)))
    values = parameters.values(known.coordinates)
    chosen = [parameters.parameters[index] for index in asked]
    return Suggestion(
        values={p.name: values[p.name] for p in chosen},
        units={p.name: p.unit for p in chosen},
        now=_expected(replace(views[0][0], name='now', words='now'), known, known, asked),
        ranked=tuple(sorted(found, key=lambda one: -one.bits)),
        refused=tuple(refused),
    )


def _as_recorded(scene: Scene, setup: ObservationSetup) -> tuple[Candidate, FloatArray]:
    """Return an observation of the scene as a candidate, and the middle of its body."""
    body = pose_body(scene, setup)
    camera: PinholeCamera = scene.depth_camera or DEPTH_CAMERA
    pose = setup.stored_depth_from_world
    if pose is None:
        pose = default_view(
            body.positions,
            body.outward,
            setup.gravity,
            scene.marker,
            camera,
            scene.color_camera or COLOR_CAMERA,
        )
    candidate = Candidate(
        name=setup.name,
        words=setup.name,
        setup=setup,
        camera=camera,
        depth_from_world=pose,
        pose_covariance=None if scene.marker is None else np.diag(_POSE_STD**2),
    )
    return candidate, 0.5 * (body.positions.min(axis=0) + body.positions.max(axis=0))


def _expected(candidate: Candidate, before: Known, after: Known, asked: list[int]) -> Expected:
    old, new = (known.covariance[np.ix_(asked, asked)] for known in (before, after))
    errors = {}
    for row, index in enumerate(asked):
        parameter = after.parameters.parameters[index]
        value = parameter.value(after.coordinates[index])
        rate = abs(value) if parameter.is_logarithmic else 1.0
        errors[parameter.name] = rate * float(np.sqrt(new[row, row]))
    bits = 0.5 * (np.linalg.slogdet(old)[1] - np.linalg.slogdet(new)[1]) / np.log(2.0)
    return Expected(candidate.name, candidate.words, errors, float(bits))
