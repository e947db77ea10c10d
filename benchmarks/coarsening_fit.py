# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit coarser meshes of a body to what its finest mesh looks like, in processes of their own."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from multiprocessing import get_context
import resource
import time
from typing import Any

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.model import Scene
from diffcal_ros.synthetic.posed_body import pose_body, PosedBody
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
# From a body at rest, `depth_from_world`, shape (4, 4).
Look = Callable[[PosedBody], FloatArray]

# Of the true modulus.
_START = 1.3


def target(truth: Scene, camera: PinholeCamera, look: Look) -> dict[str, Any]:
    """Render a body of quadratic elements, with the noise and the steps of an L515."""
    truth = replace(truth, element=Element.QUADRATIC)
    begun = time.perf_counter()
    body = pose_body(truth, truth.observations[0])
    seconds = time.perf_counter() - begun
    pose = look(body)
    points = apply(pose, body.positions)
    depth = DepthTracer(body.triangles, len(points), camera).trace(points).full_depth()
    noisy = depth + np.random.default_rng(5).normal(scale=0.00014, size=depth.shape)
    return {
        'depth': (np.round(noisy / 0.00025) * 0.00025).astype(np.float32),
        'depth_from_world': pose,
        'tets': truth.mesh.tet_count,
        'largest_sag_mm': 1e3 * body.largest_displacement,
        'cold_s': seconds,
        'peak_mb': _peak(),
    }


def fit(
    scene: Scene, element: str, camera: PinholeCamera, seen: dict[str, Any], start: float
) -> dict[str, Any]:
    """Fit one mesh with one element from a share of the truth, which the scene starts with."""
    truth = scene.regions[0].youngs_modulus
    started = replace(scene.regions[0], youngs_modulus=replace(truth, start=start * truth.start))
    own = replace(scene, element=Element(element), regions=(started,))
    begun = time.perf_counter()
    pose_body(own, own.observations[0])
    cold = time.perf_counter() - begun
    observation = Observation(own.name, 0, seen['depth'], camera, seen['depth_from_world'])
    result = calibrate(own, [observation], CalibrationSettings(with_mesh_error=False))
    return {
        'element': element,
        'started_at': start,
        'tets': own.mesh.tet_count,
        'volume_cm3': 1e6 * float(own.mesh.volumes.sum()),
        'share_of_true_modulus': result['youngs_modulus'].value / truth.start,
        'gap_median_mm': 1e3 * result.gap_end.median,
        'gap_rms_mm': 1e3 * result.gap_end.rms,
        'outcome': result.outcome.value,
        'iterations': result.iterations,
        'fit_s': result.seconds,
        'cold_s': cold,
        'peak_mb': _peak(),
    }


def _peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def compare(
    scenes: Sequence[Scene],
    camera: PinholeCamera,
    look: Look,
    *,
    linear_only: Sequence[Scene] = (),
    linear_start: float = _START,
) -> dict[str, Any]:
    """Render the first scene and fit all of them with each element.

    Args:
        scenes: the same body on meshes of other sizes, the finest first.
        camera: that looks at it.
        look: from where.
        linear_only: further meshes, fitted with linear elements.
        linear_start: share of the true modulus from which fits with linear elements start. A
            slender body on a coarse mesh is so stiff that from the truth it would be out of the
            residual's reach.
    """
    asked = [(scene, element) for scene in reversed(scenes) for element in Element]
    asked += [(scene, Element.LINEAR) for scene in linear_only]
    rows = []
    with get_context('spawn').Pool(1, maxtasksperchild=1) as pool:
        seen = pool.apply(target, (scenes[0], camera, look))
        print({name: seen[name] for name in ('tets', 'largest_sag_mm', 'cold_s')}, flush=True)
        # The cheap ones first: what goes wrong shows soon.
        for scene, element in asked:
            start = linear_start if element is Element.LINEAR else _START
            rows.append(pool.apply(fit, (scene, element.value, camera, seen, start)))
            print(rows[-1], flush=True)
    rows.sort(key=lambda row: (-row['tets'], row['element']))
    return {
        'target': {name: seen[name] for name in seen if name not in ('depth', 'depth_from_world')},
        'rows': rows,
        **_summary(rows),
    }


def _summary(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    shares = {
        element.value: {
            row['tets']: row['share_of_true_modulus']
            for row in rows
            if row['element'] == element.value
        }
        for element in Element
    }
    # Over the meshes that both elements were fitted on.
    spread = {
        name: float(np.ptp([own[tets] for tets in shares['quadratic']]))
        for name, own in shares.items()
    }
    linear = list(shares['linear'].values())
    return {
        'spread': spread,
        'spread_ratio': spread['quadratic'] / spread['linear'],
        'linear_falls_with_coarseness': bool((np.diff(linear) < 0.0).all()),
    }
