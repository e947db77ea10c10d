# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Observations of a beam that were watched for several frames, from another mesh."""

from dataclasses import replace
from functools import cache

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.observations.observation import fuse_frames, Observation
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.residuals.robust_residual import make_comparers
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.trace import Trace
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.scene.model import Scene
import numpy as np
from scipy.ndimage import gaussian_filter

from support.scenes import beam_scene, noisy, observation, true_depth

_FRAMES = 8


_beam = cache(beam_scene)
# The body is in one place wherever the camera errs, and traced once for each scene.
_TRACES: dict[tuple[int, int, PinholeCamera, bytes], tuple[Scene, Trace]] = {}


def watched(*, seed: int, tilt: float = 0.0, bias: float = 0.0) -> Observation:
    """Look at the beam for eight frames.

    Args:
        seed: of noise and of the sensor's smooth error.
        tilt: of gravity about the axis towards the camera [rad].
        bias: of the depth camera [m].
    """
    random = np.random.default_rng(seed)
    gravity = 9.8 * np.array([0.0, -np.cos(tilt), np.sin(tilt)])
    exact = true_depth(gravity=gravity) + bias
    smooth = gaussian_filter(random.normal(size=exact.shape), 40.0)
    return several_frames(exact + 0.00012 * smooth / smooth.std(), random)


def several_frames(exact: np.ndarray, random: np.random.Generator) -> Observation:
    """Look at a true depth image [m], shape (H, W), for eight frames."""
    images = [noisy(exact, random).astype(np.float32) for _ in range(_FRAMES)]
    fused = fuse_frames([DepthFrame(image, number) for number, image in enumerate(images)])
    return replace(observation(fused.depth), frame_count=_FRAMES, noise=fused.noise)


def with_step(
    observation: Observation,
    at: float,
    step: float,
    counts: tuple[int, int, int] = (8, 2, 2),
) -> Observation:
    """Let the camera read too far beyond a share of the body's length.

    Args:
        observation: of the beam.
        at: share of its free length.
        step: of depth [m].
        counts: elements of the mesh between two of whose layers it lies.
    """
    return with_part(observation, {'at': at}, step, _beam(counts))


def _traced(scene: Scene, seen: Observation) -> Trace:
    """Return what a camera sees of a body without an error."""
    key = id(scene), seen.setup_index, seen.camera, seen.depth_from_world.tobytes()
    if key not in _TRACES:
        model = ForwardModel(scene, [seen], make_parameters(scene, ('youngs_modulus',)))
        _TRACES[key] = scene, model.views(model.parameters.start())[0].trace
    return _TRACES[key][1]


def with_part(
    observation: Observation,
    settings: dict[str, float],
    step: float,
    scene: Scene,
) -> Observation:
    """Let the camera read too far on a part of the body.

    Args:
        observation: of the beam.
        settings: of `depth_bias_by_region`, which say where.
        step: of depth [m].
        scene: of the beam, with the posture.
    """
    trace = _traced(scene, observation)
    scene = replace(scene, effects={'depth_bias_by_region': settings})
    model = ForwardModel(scene, [observation], make_parameters(scene, ('youngs_modulus',)))
    beyond = make_comparers(model)[0].is_second(trace) & (trace.faces >= 0)
    depth = observation.depth.copy()
    depth[trace.rows, trace.columns][beyond] += np.float32(step)
    return replace(observation, depth=depth)
