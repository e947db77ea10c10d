# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The field's gradient and curvature against differences of the cost on frozen residuals.

The robust cost itself is rough: pixels join and leave it, segments of outline are cut anew and the
observed edge is found anew at every evaluation. Differences of it along a field that is rough
from tetrahedron to tetrahedron, and so hardly moves the body, show mostly that. What a step is
made from is its slope on the residuals of one instant, so that is what is differenced here.
"""

from dataclasses import replace

from diffcal_ros.calibration.field.layout import FieldKind, tets_from_unknowns
from diffcal_ros.calibration.field.linear_system import FieldSystem
from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.robust_loss import robust_channel
from diffcal_ros.fem.statics.force_changes import Change
import numpy as np
import pytest
from support.scenes import beam_scene, CAMERA, observation, true_depth

# Of the log moduli; a direction's largest entry is one.
STEPS = (8e-3, 4e-3, 2e-3)
# Depth within a triangle and the outline's place are smooth; pixels that another triangle takes
# over see a kink of the surface, the smaller the step the fewer.
_RELATIVE = 2e-3


class _Setup:
    """A beam a third too stiff, with a field, and its robust cost in the final form."""

    def __init__(self, random, effects) -> None:
        scene = replace(beam_scene((6, 2, 2), modulus=80e3), effects=effects)
        parameters = make_parameters(scene, ('youngs_modulus', 'rigid_offset'))
        self.uniform = ForwardModel(scene, [observation(true_depth())], parameters)
        self.coordinates = parameters.start()
        self.coordinates[1:7] = [0.001, -0.001, 0.002, 0.01, -0.02, 0.01]
        self.field = 0.3 * random.normal(size=scene.mesh.tet_count)
        self.model = self.with_field(self.field)
        self.objective = RobustObjective(self.model)
        while not self.objective.is_annealed:
            self.objective.anneal(self.coordinates)
        self.spread = tets_from_unknowns(scene.mesh, FieldKind())

    def with_field(self, field: np.ndarray) -> ForwardModel:
        scene = replace(self.uniform.scene, relative_modulus=np.exp(field))
        return self.uniform.with_parameters(scene, self.uniform.parameters)

    def system(self) -> FieldSystem:
        return FieldSystem(self.objective, self.coordinates, self.spread)

    def directions(self, random) -> list[np.ndarray]:
        """From tetrahedron to tetrahedron at random, and along and across the beam."""
        x, y, z = self.model.scene.mesh.centroids.T
        rough = random.normal(size=(2, len(x)))
        smooth = [np.sin(40.0 * x + 60.0 * y), np.cos(25.0 * x) * z / 0.018]
        return [d / np.abs(d).max() for d in (*rough, *smooth)]


@pytest.fixture(
    params=[{}, {'compliant_clamp': {'compliance': 0.5}}], ids=['plain', 'a clamp that gives way']
)
def setup(random, request) -> _Setup:
    return _Setup(random, request.param)


class _Frozen:
    """The cost on the residuals of one instant: the same pixels, segments and observed edges."""

    def __init__(self, setup: _Setup) -> None:
        self._setup, model = setup, setup.model
        (comparison,) = setup.objective.comparisons(setup.coordinates)
        comparison = setup.objective.unbiased(comparison, setup.coordinates)
        self._depth, self._edge = comparison.depth, comparison.edge
        self._metres = comparison.edge_scale
        (view,) = model.views(setup.coordinates)
        segments, places = view.trace.segments, comparison.edge.indices
        self._normals = segments.normals.numpy()[places]
        shares = segments.fractions.numpy()[places][:, None]
        ends = model.tracers[0].edge_vertices[segments.edges.numpy()[places]]
        self._where = lambda points: (
            (1.0 - shares) * CAMERA.project(points[ends[:, 0]])
            + shares * CAMERA.project(points[ends[:, 1]])
        )
        self._edge_start = self._where(view.points)
        columns, rows = comparison.depth.pixels.T
        self._pixels = rows, columns
        self._depth_start = view.trace.full_depth()[self._pixels]

    def cost(self, field: np.ndarray) -> float:
        setup, scales = self._setup, self._setup.objective.scales
        (view,) = setup.with_field(field).views(setup.coordinates)
        fallen = view.trace.full_depth()[self._pixels] - self._depth_start
        moved = ((self._where(view.points) - self._edge_start) * self._normals).sum(axis=1)
        return _cauchy(self._depth, self._depth.values - fallen, scales.depth, 2) + _cauchy(
            self._edge, self._edge.values - moved * self._metres, scales.edge, 1
        )


def _cauchy(residuals, values, scale, dimension) -> float:
    costs = 0.5 * scale.width**2 * np.log1p((values / scale.width) ** 2)
    return float(residuals.weights @ costs) / (scale.noise**2 * scale.patch(dimension))


@pytest.mark.parametrize('step', STEPS)
def test_gradient_by_every_tetrahedron(setup: _Setup, step: float, random) -> None:
    gradient = -setup.system().field_negative_gradient
    frozen = _Frozen(setup)
    for direction in setup.directions(random):
        above, below = (frozen.cost(setup.field + sign * step * direction) for sign in (1, -1))
        slope = (above - below) / (2.0 * step)
        # A rough direction nearly cancels: errors are held against what each entry could give.
        size = np.linalg.norm(gradient) * np.linalg.norm(direction)
        assert abs(slope - float(gradient @ direction)) < _RELATIVE * size


def test_the_gradient_holds_the_scalar_one(setup: _Setup) -> None:
    system = setup.system()
    place = setup.model.parameters.names.index('youngs_modulus')
    assert system.field_negative_gradient.sum() == pytest.approx(
        system.negative_gradient[place], rel=1e-8
    )
    np.testing.assert_allclose(
        system.mixed.sum(axis=0), system.curvature[place], rtol=1e-7, atol=1e-6
    )


def test_known_is_least_squares_without_the_ordinary_parameters(setup: _Setup, random) -> None:
    system, objective, model = setup.system(), setup.objective, setup.model
    directions = np.stack(setup.directions(random))
    inner = directions @ np.stack([system.known(d) for d in directions], axis=1)
    # The other route: all columns pushed forward, and the ordinary ones taken out by QR.
    modulus = model.material(setup.coordinates).youngs_modulus
    changes = [Change(youngs_modulus=d * modulus) for d in directions]
    (ordinary,) = model.tangents(setup.coordinates)
    (fields,) = model.tangents_of(lambda *_: changes, setup.coordinates)
    (view,), (comparison,) = (
        model.views(setup.coordinates),
        objective.comparisons(setup.coordinates),
    )
    wide = np.concatenate([ordinary, fields])
    rows = [
        channel.jacobian * np.sqrt(channel.weights.curvature)[:, None]
        for channel in (
            robust_channel(*own, objective.scales)
            for own in objective.with_jacobians(0, comparison, view, wide, setup.coordinates)
        )
    ]
    _, precision = model.parameters.prior()
    count = len(precision)
    # Priors are rows, too; they know nothing of the field.
    roots = np.sqrt(np.diag(precision))
    prior = np.concatenate([np.diag(roots), np.zeros((count, len(directions)))], axis=1)
    whole = np.concatenate([*rows, prior])
    basis, _ = np.linalg.qr(whole[:, :count])
    left = whole[:, count:] - basis @ (basis.T @ whole[:, count:])
    scale = np.abs(inner).max()
    np.testing.assert_allclose(inner, left.T @ left, atol=1e-7 * scale)
    # A field that is the same everywhere is the modulus, which is free.
    assert np.abs(directions @ system.known(np.ones(directions.shape[1]))).max() < 1e-7 * scale


def test_a_control_grid_sees_the_same_gradient(setup: _Setup) -> None:
    mesh = setup.model.scene.mesh
    grid = tets_from_unknowns(mesh, FieldKind(spacing=0.02))
    coarse = FieldSystem(setup.objective, setup.coordinates, grid)
    np.testing.assert_allclose(
        coarse.field_negative_gradient, grid.T @ setup.system().field_negative_gradient, rtol=1e-9
    )
