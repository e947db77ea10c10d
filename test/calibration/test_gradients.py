# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From parameters through simulation and tracing to the loss: derivatives by differences."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.whole_image.image_objective import ImageObjective
from diffcal_ros.fem.elements.element import Element
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from support.scenes import beam_scene, CAMERA, observation, true_depth

FIT = ('youngs_modulus', 'poissons_ratio', 'density', 'gravity_tilt', 'rigid_offset')
# Coordinates away from zero, so that second-order mistakes of the offsets show.
_AWAY = {'gravity_tilt.a': 0.05, 'gravity_tilt.b': -0.08}
_OFFSET = (0.003, -0.002, 0.004, 0.06, -0.05, 0.08)
# Shares of the longest sensible step; the outline moves by well under a tenth of a pixel.
STEPS = (4e-3, 2e-3, 1e-3)
_STEP_OF = {'youngs_modulus': 1.0, 'density': 1.0, 'poissons_ratio': 0.1, 'gravity_tilt': 1.0}
_RELATIVE = 0.01


def _coordinates(parameters) -> np.ndarray:
    start = parameters.start()
    for place, parameter in enumerate(parameters):
        if parameter.name in _AWAY:
            start[place] = _AWAY[parameter.name]
        if parameter.kind.value == 'rigid_offset':
            start[place] = _OFFSET[parameter.axis]
    return start


def _step_sizes(parameters, step: float) -> np.ndarray:
    return np.array(
        [step * _STEP_OF.get(p.kind.value, 0.03 if p.axis < 3 else 0.15) for p in parameters]
    )


class _SmoothLoss(ImageObjective):
    """A whole-image loss against a smooth target: differences of it are clean."""

    def __init__(self, model: ForwardModel, random: np.random.Generator) -> None:
        super().__init__(model, 'paper', samples=128)
        noise = gaussian_filter(random.normal(size=(CAMERA.height, CAMERA.width)), 6.0)
        self._targets = [0.25 + 2.0 * noise]


@pytest.fixture(params=list(Element), ids=lambda e: e.value)
def loss(request, random) -> _SmoothLoss:
    scene = replace(beam_scene((6, 2, 2)), element=request.param)
    parameters = make_parameters(scene, FIT, with_edge_bias=False)
    model = ForwardModel(scene, [observation(true_depth())], parameters)
    return _SmoothLoss(model, random)


@pytest.mark.parametrize('step', STEPS)
@pytest.mark.slow_but_first
def test_whole_chain_gradient(loss: _SmoothLoss, step: float) -> None:
    parameters = loss.model.parameters
    start = _coordinates(parameters)
    sizes = _step_sizes(parameters, step)
    _, gradient = loss.gradient(start)
    slopes = np.empty(len(start))
    for place, size in enumerate(sizes):
        change = np.zeros(len(start))
        change[place] = size
        slopes[place] = (loss.value(start + change) - loss.value(start - change)) / (2.0 * size)
    # In units of a sensible step, so that metres and radians compare.
    scale = sizes / step
    error = np.abs(slopes - gradient) * scale
    assert error.max() < _RELATIVE * np.abs(gradient * scale).max()


def test_modulus_gradient_by_itself(loss: _SmoothLoss) -> None:
    # A target that grows along the sag: nothing cancels in the slope by the modulus.
    rows = np.linspace(0.0, 1.0, CAMERA.height)[:, None]
    loss._targets = [np.broadcast_to(0.1 + 0.4 * rows, (CAMERA.height, CAMERA.width))]
    start = _coordinates(loss.model.parameters)
    _, gradient = loss.gradient(start)
    for step in STEPS:
        change = np.zeros(len(start))
        change[0] = step
        slope = (loss.value(start + change) - loss.value(start - change)) / (2.0 * step)
        assert slope == pytest.approx(gradient[0], rel=_RELATIVE)


def test_forward_and_adjoint_routes_agree(loss: _SmoothLoss) -> None:
    start = _coordinates(loss.model.parameters)
    value, gradient = loss.gradient(start)
    linear = loss.linearise(start)
    # L = 1000 sqrt(S): dL = 1e6 / (2 L) dS, and the cost is S / (2 noise).
    by_forward = -linear.negative_gradient * loss._noise * 1e6 / value
    np.testing.assert_allclose(by_forward, gradient, rtol=1e-6, atol=1e-6 * np.abs(gradient).max())


def test_per_tetrahedron_gradient_sums_to_the_scalar_one(loss: _SmoothLoss) -> None:
    model = loss.model
    start = _coordinates(model.parameters)
    value, gradient = loss.gradient(start)
    view = loss._views(start)[0]
    by_points = view.area.pull_back(loss._by_image(view.difference, value))
    by_world = by_points @ model.cameras.rotation(0, start)
    static = model.body(model.observations[0]).gradient(by_world)
    modulus = model.material(start).youngs_modulus
    assert float(static.youngs_modulus @ modulus) == pytest.approx(gradient[0], rel=1e-9)


def test_robust_slope_points_down_the_robust_cost() -> None:
    # Noise-free, a tenth off in modulus, 2 mm and 1 degree off in pose.
    scene = beam_scene((6, 2, 2), modulus=66e3)
    parameters = make_parameters(scene, ('youngs_modulus', 'rigid_offset'))
    model = ForwardModel(scene, [observation(true_depth())], parameters)
    objective = RobustObjective(model)
    start = parameters.start()
    start[1:7] = [0.002, -0.002, 0.002, 0.02, -0.02, 0.02]
    for _ in range(8):
        objective.anneal(start)
    linear = objective.linearise(start)
    sizes = 0.3 / np.sqrt(np.diag(linear.curvature))
    slopes = np.empty(len(start))
    for place, size in enumerate(sizes):
        change = np.zeros(len(start))
        change[place] = size
        rise = objective.cost(start + change) - objective.cost(start - change)
        slopes[place] = rise / (2.0 * size)
    # Pixels join and leave and edges are found to a fraction of a pixel: the direction is right
    # to a few degrees.
    ours, differences = linear.negative_gradient * sizes, -slopes * sizes
    cosine = ours @ differences / (np.linalg.norm(ours) * np.linalg.norm(differences))
    assert cosine > 0.97
    assert np.linalg.norm(ours) == pytest.approx(np.linalg.norm(differences), rel=0.2)
