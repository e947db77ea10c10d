# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Pixels at the border of two materials, of which nobody knows the one that they show.

Regions are made of whole elements: where one material ends is known to half an element at best. A
depth camera that reads one of them centimetres too far is off by all of that in a strip along the
border, and what is left there says nothing about the body.
"""

from collections.abc import Sequence

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.residuals.robust_residual import Residuals, ViewComparer
from diffcal_ros.effects.registry import boundary_effects
from diffcal_ros.effects.surface_parts import SeenPart
from diffcal_ros.scene.model import Scene
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]

# Points along each edge of the border: the strip is wider than they are apart.
_ALONG = np.linspace(0.0, 1.0, 5)[:, None, None]
# Of what is between two borders of bands the strips along them take no more than this each.
_MOST_OF_BAND = 0.125


class BoundaryStrip:
    """The strip along the border of two materials, as wide as half an element to either side.

    Of narrow bands in a body of one region, whose borders are no elements', it is less.

    It is the same for every model of a diagnosis, so that none wins by leaving it out.
    """

    def __init__(self, model: ForwardModel, comparers: Sequence[ViewComparer]) -> None:
        """Prepare the views of a model.

        Args:
            model: whose scene knows the border.
            comparers: of its observations.
        """
        self._comparers = list(comparers)
        meshes = [model.body(observation).mesh for observation in model.observations]
        self._widths = [0.5 * _element_size(mesh) for mesh in meshes]
        setups = [observation.setup_index for observation in model.observations]
        lengths = [model.effects.object_axes(setup).length for setup in setups]
        self._shares = [
            min(width / length, _MOST_OF_BAND * _narrowest(_borders(comparer.surface.parts)))
            for width, length, comparer in zip(self._widths, lengths, comparers, strict=True)
        ]

    def without(self, number: int, view: View, depth: Residuals) -> BoolArray:
        """Tell which residuals of a view's depth are beside the strip, shape (M,)."""
        comparer = self._comparers[number]
        clear = np.ones(len(depth.indices), dtype=bool)
        if comparer.surface.parts:
            places = comparer.places(view.trace, depth.indices)
            return _beside_limits(places, comparer.surface.parts, self._shares[number])
        tracer = view.tracer
        faces = tracer.edge_faces
        is_second = comparer.surface.is_second
        meets = (faces.min(axis=1) >= 0) & (is_second[faces[:, 0]] != is_second[faces[:, 1]])
        if not meets.any() or len(clear) == 0:
            return clear
        first, second = view.points[tracer.edge_vertices[meets]].transpose(1, 0, 2)
        border = (first + _ALONG * (second - first)).reshape(-1, 3)
        z = view.trace.depth.ravel()[depth.indices]
        columns, rows = depth.pixels.T
        camera = tracer.camera
        seen = np.stack(
            [(columns - camera.cx) / camera.fx * z, (rows - camera.cy) / camera.fy * z, z], axis=1
        )
        width = self._widths[number]
        distances, _ = cKDTree(border).query(seen, distance_upper_bound=width)
        return np.asarray(~np.isfinite(distances))


def knows_boundary(scene: Scene) -> bool:
    """Tell whether a scene has several regions, or states where effects have their boundary."""
    return len(scene.regions) > 1 or any(
        effect.identifier in scene.effects for effect in boundary_effects()
    )


def _beside_limits(places: FloatArray, parts: Sequence[SeenPart], share: float) -> BoolArray:
    """Tell which points are beside the strips along the limits of parts, shape (n,).

    Args:
        places: see `BodyAxes.on_surface`, shape (n, 3).
        parts: of the surface.
        share: half width of the strip at each border, as a share of the free length.
    """
    clear = np.ones(len(places), dtype=bool)
    for part in parts:
        width = _MOST_OF_BAND * min(_narrowest(own, -1.0) for own in part.limits_across)
        inner, outer = part.holds(places, (-share, -width)), part.holds(places, (share, width))
        clear &= inner | ~outer
    return clear


def _borders(parts: Sequence[SeenPart]) -> list[float]:
    """Return where parts begin and end along a body, ascending."""
    return sorted({place for part in parts for place in part.borders})


def _narrowest(borders: Sequence[float], begin: float = 0.0) -> float:
    """Return what is between the nearest two borders, from a beginning to 1."""
    return float(np.diff([begin, *(own for own in borders if own > begin), 1.0]).min())


def _element_size(mesh: TetMesh) -> float:
    """Return the usual length of an element's edge [m]."""
    edges, _ = mesh.edges
    ends = mesh.rest_positions[edges]
    return float(np.median(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)))
