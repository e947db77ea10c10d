# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Mitsuba 3: a depth picture and its derivative by the vertices, outline included.

Mitsuba's projective sampling differentiates radiance alone, so the body shines with its own depth:
a vertex attribute that follows the vertices is what the area emitter emits. With a box filter a
pixel is the mean of depth over its area, zero beside the body, as our own `area_image`.
"""

from importlib.metadata import version
from typing import Any

from clock import Case, run_studies, timed
import drjit as dr
import mitsuba as mi
import numpy as np

_VARIANT = 'llvm_ad_mono'
_SAMPLES = (4, 16, 64)
_BUDGET = 6.0


class Picture:
    """One body before a camera, and the loss of its depth against a target."""

    def __init__(self, case: Case) -> None:
        # Mitsuba's pixels are square: stretching the body makes up for the two focal lengths.
        self.stretch = float(case['camera'][1] / case['camera'][0])
        points = case['points'] * np.array([1.0, self.stretch, 1.0])
        self.scene = mi.load_dict(
            {
                'type': 'scene',
                'body': _body(points, case['triangles']),
                'sensor': _sensor(case),
                # Depth 1 is what the camera sees shine, without any bounce.
                'integrator': {'type': 'prb_projective', 'max_depth': 1, 'sppi': 0},
            }
        )
        self.parameters = mi.traverse(self.scene)
        self.points = mi.Float(points.astype(np.float32).ravel())
        self.target = mi.TensorXf(case['target'].astype(np.float32)[..., None])
        self.image = self.gradient = np.zeros(0)
        self.seed = 0

    def render(self, samples: int) -> None:
        """Render depth alone."""
        self.seed += 1
        self.image = np.array(mi.render(self.scene, spp=samples, seed=self.seed))[..., 0]

    def both(self, samples: int) -> None:
        """Render, and pull the squared difference to the target back to the vertices."""
        self.seed += 1
        points = mi.Float(self.points)
        dr.enable_grad(points)
        self.parameters['body.vertex_positions'] = points
        self.parameters['body.vertex_depth'] = dr.gather(
            mi.Float, points, 3 * dr.arange(mi.UInt32, dr.width(points) // 3) + 2
        )
        self.parameters.update()
        image = mi.render(
            self.scene, self.parameters, spp=samples, spp_grad=samples, seed=self.seed
        )
        dr.backward(dr.sum(dr.square(image - self.target), axis=None))
        gradient = np.array(dr.grad(points), dtype=float).reshape(-1, 3)
        self.gradient = gradient * np.array([1.0, self.stretch, 1.0])
        dr.disable_grad(points)


def _body(points: Any, triangles: Any) -> Any:
    """Return the mesh, which shines with its vertices' depth."""
    props = mi.Properties()
    radiance = {'type': 'mesh_attribute', 'name': 'vertex_depth'}
    props['emitter'] = mi.load_dict({'type': 'area', 'radiance': radiance})
    props['bsdf'] = mi.load_dict({'type': 'diffuse', 'reflectance': 0.0})
    body = mi.Mesh('body', len(points), len(triangles), props=props)
    body.add_attribute('vertex_depth', 1, points[:, 2].astype(np.float32))
    parameters = mi.traverse(body)
    parameters['vertex_positions'] = mi.Float(points.astype(np.float32).ravel())
    parameters['faces'] = mi.UInt32(triangles.astype(np.uint32).ravel())
    parameters.update()
    return body


def _sensor(case: Case) -> dict[str, Any]:
    """Return our pinhole (z forward, y down, pixel centres at whole numbers) on its window.

    The film is the window itself: of a film with a crop, Mitsuba 3.9.1 loses the outline's share
    of the derivative.
    """
    left, top, right, bottom = (int(side) for side in case['window'])
    width, height = right - left, bottom - top
    focal, centre = float(case['camera'][0]), case['camera'][2:] + 0.5 - (left, top)
    return {
        'type': 'perspective',
        'fov': float(2.0 * np.degrees(np.arctan(width / (2.0 * focal)))),
        'fov_axis': 'x',
        'near_clip': 0.01,
        'far_clip': 10.0,
        'principal_point_offset_x': float(0.5 - centre[0] / width),
        'principal_point_offset_y': float(0.5 - centre[1] / height),
        'to_world': mi.ScalarTransform4f().look_at(
            origin=[0, 0, 0], target=[0, 0, 1], up=[0, -1, 0]
        ),
        'film': {
            'type': 'hdrfilm',
            'width': width,
            'height': height,
            'rfilter': {'type': 'box'},
            'pixel_format': 'luminance',
            'component_format': 'float32',
        },
        'sampler': {'type': 'independent'},
    }


def depth(case: Case) -> tuple[dict[str, Any], dict[str, Any]]:
    """Time several sample counts; the main process judges their gradients."""
    picture = Picture(case)
    rows, arrays = {}, {}
    for samples in _SAMPLES:
        forward = timed(lambda samples=samples: picture.render(samples), budget=_BUDGET)
        both = timed(lambda samples=samples: picture.both(samples), budget=_BUDGET)
        rows[f'samples_{samples}'] = {'forward': forward, 'both': both}
        arrays[f'gradient_samples_{samples}'] = picture.gradient
    arrays['image'] = picture.image
    figures = {
        'variant': _VARIANT,
        'integrator': 'prb_projective; the body shines with its own depth',
        'precision': 'single',
        'rows': rows,
    }
    return figures, arrays


def main() -> None:
    """Measure on one thread."""
    # Without an LLVM library this fails, and the reason is reported.
    mi.set_variant(_VARIANT)
    dr.set_thread_count(1)
    mi.set_log_level(mi.LogLevel.Error)
    names = ('mitsuba', 'drjit')
    run_studies({name: version(name) for name in names}, {'depth': depth})


if __name__ == '__main__':
    main()
