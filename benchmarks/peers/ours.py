# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Our own package on the case of the command line: run as a module, in a process of its own."""

from importlib.metadata import version
from typing import Any

from diffcal_ros.damping import Damping
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import st_venant_kirchhoff
from diffcal_ros.fem.motion.moving_body import MovingBody
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.tet_mesh import TetMesh
import numpy as np

from benchmarks.peers.case import CAMERA, GRAVITY, held_vertices, material, release
from benchmarks.peers.clock import Case, run_studies, timed

_FINE_STEP = 1.0 / 3840.0
_SIDE = 8  # Squared: rays of an outline pixel that cannot be cut exactly.


def _mesh(case: Case) -> TetMesh:
    return TetMesh(case['positions'], case['tets'].astype(np.int32))


def equilibrium(case: Case, element: Element) -> tuple[dict[str, Any], dict[str, Any]]:
    """Time one element from rest, and say what the tip does under MuJoCo's law."""
    mesh = _mesh(case)
    body = StaticBody(mesh, element, held_vertices(mesh))
    solid, by_tip = material(mesh.tet_count), np.zeros_like(body.discretisation.rest_nodes)
    by_tip[case['tip'], 1] = 1.0

    def solve() -> Any:
        body.forget()
        return body.solve_equilibrium(solid, GRAVITY).positions

    def both() -> float:
        solve()
        return float(body.gradient(by_tip).youngs_modulus @ solid.youngs_modulus)

    forward, total = timed(solve), timed(both)
    figures = {
        'law': 'stable neo-Hookean (Smith et al. 2018)',
        'solver': body.solver.stiffness.solver_name,
        'forward': forward,
        'both': total,
        'tip_slope_mm': 1e3 * both(),
    }
    arrays = {'displacement': solve() - body.discretisation.rest_nodes}
    if element is Element.LINEAR:
        law = st_venant_kirchhoff
        other = StaticBody(mesh, element, held_vertices(mesh), law=law)
        solid = material(mesh.tet_count, conversion=law.CONVERSION)
        state = other.solve_equilibrium(solid, GRAVITY)
        slope = other.gradient(by_tip).youngs_modulus @ solid.youngs_modulus
        figures['tip_slope_st_venant_kirchhoff_mm'] = 1e3 * float(slope)
        arrays['displacement_st_venant_kirchhoff'] = state.positions - case['positions']
    return figures, arrays


def _moving(case: Case, law: Any = None, step: float | None = None) -> tuple[MovingBody, Any]:
    """Return the released body, and what swings it and returns its tip's path."""
    mesh = _mesh(case)
    options = {} if law is None else {'law': law}
    static = StaticBody(mesh, Element.LINEAR, held_vertices(mesh), **options)
    body = MovingBody(static, release(mesh), time_step=step)
    conversion = {} if law is None else {'conversion': law.CONVERSION}
    solid, none = material(mesh.tet_count, **conversion), Damping(np.zeros(mesh.tet_count))
    stamps = np.array([case['duration']])
    return body, lambda: body.simulate(solid, none, GRAVITY, stamps).positions


def motion(case: Case) -> tuple[dict[str, Any], dict[str, Any]]:
    """Time the default step, and give the path's end in the limit of short ones."""
    body, swing = _moving(case)
    by_tip = np.zeros((1, len(case['positions']), 3))
    by_tip[0, case['tip'], 1] = 1.0

    def both() -> float:
        swing()
        return float(body.gradient(by_tip).youngs_modulus.sum() * case['modulus'])

    forward, total = timed(swing), timed(both)
    fine, fine_swing = _moving(case, step=_FINE_STEP)
    arrays = {'tip': swing()[0, case['tip']], 'fine_tip': fine_swing()[0, case['tip']]}
    fine_slope = fine.gradient(by_tip).youngs_modulus.sum() * case['modulus']
    svk = _moving(case, st_venant_kirchhoff, _FINE_STEP)[1]
    arrays['fine_tip_st_venant_kirchhoff'] = svk()[0, case['tip']]
    figures = {
        'law': 'stable neo-Hookean (Smith et al. 2018)',
        'steps': body.motion.step_count,
        'forward': forward,
        'both': total,
        'tip_slope_mm': 1e3 * both(),
        'fine_step_s': _FINE_STEP,
        'fine_tip_slope_mm': 1e3 * float(fine_slope),
    }
    return figures, arrays


class Picture:
    """Our depth and its loss against the target, as a peer has it."""

    def __init__(self, case: Case) -> None:
        self.tracer = DepthTracer(case['triangles'], len(case['points']), CAMERA)
        left, top, right, bottom = case['window']
        self.target = np.zeros((CAMERA.height, CAMERA.width))
        self.target[top:bottom, left:right] = case['target']

    def loss(self, points: Any, side: int) -> float:
        """Return the squared difference over the whole picture [m^2]."""
        trace = self.tracer.trace(points)
        image = np.nan_to_num(trace.in_image(trace.area_image(side=side).image))
        return float(((image - self.target) ** 2).sum())

    def gradient(self, points: Any, side: int) -> Any:
        """Return its derivative by the vertices [m], shape (N, 3)."""
        trace = self.tracer.trace(points)
        area = trace.area_image(side=side)
        target = self.target[trace.rows, trace.columns]
        return area.pull_back(2.0 * (area.image - target))

    def differences(self, points: Any, step: float = 2e-5) -> Any:
        """Return central differences of the loss along the camera's axes [m], shape (3,)."""
        ends = [
            [self.loss(points + sign * step * axis, 64) for sign in (1, -1)] for axis in np.eye(3)
        ]
        return np.array([(high - low) / (2.0 * step) for high, low in ends])


def depth(case: Case) -> tuple[dict[str, Any], dict[str, Any]]:
    """Time the picture and its gradient, and give the peers something to be judged by."""
    picture, points = Picture(case), case['points']
    forward = timed(lambda: picture.tracer.trace(points).area_image(side=_SIDE).image, repeats=99)
    both = timed(lambda: picture.gradient(points, _SIDE), repeats=99)
    arrays = {
        'gradient_ours': picture.gradient(points, _SIDE),
        'exact': picture.gradient(points, 128),
        'differences': picture.differences(points),
    }
    return {'precision': 'double', 'rows': {'ours': {'forward': forward, 'both': both}}}, arrays


if __name__ == '__main__':
    run_studies(
        {name: version(name) for name in ('numpy', 'scipy', 'warp-lang')},
        {
            'equilibrium_linear': lambda case: equilibrium(case, Element.LINEAR),
            'equilibrium_quadratic': lambda case: equilibrium(case, Element.QUADRATIC),
            'motion': motion,
            'depth': depth,
        },
    )
