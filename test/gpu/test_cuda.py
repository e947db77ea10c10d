# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A GPU gives what the processor gives: bodies at rest and rendered depth, with derivatives."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import find_law, law_names
from diffcal_ros.fem.linear_solvers import make_solver, NotPositiveDefiniteError
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import LameConvention, Material
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.warp_runtime.device_array import device_names
import numpy as np
import pytest
from support.beams import beam_mesh, held_end
from support.bodies import GRAVITY

pytestmark = pytest.mark.gpu

CAMERA = PinholeCamera(320, 240, 231.0, 232.0, 171.5, 122.0)
POSE = transform(rotation_matrix(np.array([0.25, -0.2, 0.1])), np.array([-0.05, -0.01, 0.3]))


@pytest.fixture(scope='module')
def gpu() -> str:
    """The first GPU of this machine, or skip."""
    found = [name for name in device_names() if name.startswith('cuda')]
    if not found:
        pytest.skip('no GPU on this machine')
    return found[0]


def _settled(
    device: str, element: Element, law: str = 'stable_neo_hookean'
) -> tuple[StaticBody, Material]:
    mesh = beam_mesh()
    module = find_law(law)
    body = StaticBody(mesh, element, held_end(mesh), law=module, device=device)
    modulus = 30e3 * (1.0 + 0.5 * np.sin(np.arange(mesh.tet_count)))
    ones = np.ones(mesh.tet_count)
    material = Material(
        modulus, 0.49 * ones, 1080.0 * ones, LameConvention.CONSISTENT, module.CONVERSION
    )
    body.solve_equilibrium(material, GRAVITY)
    return body, material


@pytest.mark.parametrize('element', list(Element))
@pytest.mark.parametrize('law', law_names())
def test_a_body_rests_and_follows_as_on_the_processor(gpu, element, law, random) -> None:
    (here, material), (there, _) = (_settled(device, element, law) for device in ('cpu', gpu))
    assert np.abs(here.state.positions - here.discretisation.rest_nodes).max() > 1e-3
    np.testing.assert_allclose(there.state.positions, here.state.positions, rtol=0, atol=1e-9)
    changes = [Change(youngs_modulus=material.youngs_modulus), Change(gravity=GRAVITY)]
    expected = here.tangents(changes)
    bound = 1e-6 * np.abs(expected).max()
    np.testing.assert_allclose(there.tangents(changes), expected, rtol=0, atol=bound)
    by_positions = random.normal(size=here.state.positions.shape)
    expected = here.gradient(by_positions).youngs_modulus
    bound = 1e-6 * np.abs(expected).max()
    found = there.gradient(by_positions).youngs_modulus
    np.testing.assert_allclose(found, expected, rtol=0, atol=bound)


def test_the_gpu_factors_as_the_processor_again_and_again(gpu, random) -> None:
    mesh = beam_mesh((24, 6, 5))
    body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh))
    ones = np.ones(mesh.tet_count)
    pattern = body.solver.stiffness.pattern
    here, there = (
        make_solver(pattern, name, needs_exact=True, device=gpu)
        for name in ('multifrontal', 'multifrontal_torch')
    )
    sides = random.normal(size=(pattern.size, 3))
    for modulus in (20e3, 90e3):
        material = Material(modulus * ones, 0.45 * ones, 1080.0 * ones, LameConvention.CONSISTENT)
        body.elastic.set_lame_parameters(material.lame_parameters())
        values = body.solver.stiffness.values(body.own_discretisation.rest_nodes)
        here.factor(values)
        there.factor(values)
        for right in (sides, sides[:, 0], sides[:, 1]):
            expected = here.solve(right)
            bound = 1e-9 * np.abs(expected).max()
            np.testing.assert_allclose(there.solve(right), expected, rtol=0, atol=bound)
    with pytest.raises(NotPositiveDefiniteError):
        there.factor(-values)


def test_a_large_body_on_a_gpu_is_factored_there(gpu) -> None:
    mesh = beam_mesh((24, 6, 5))
    body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh), device=gpu)
    assert body.solver.stiffness.pattern.size > 10_000
    assert body.solver.stiffness.solver_name == 'multifrontal_torch'


def test_depth_and_its_gradient_are_as_on_the_processor(gpu, random) -> None:
    body, _ = _settled('cpu', Element.QUADRATIC)
    points = apply(POSE, body.state.positions)
    images, gradients = [], []
    weights = None
    for device in ('cpu', gpu):
        tracer = DepthTracer(
            body.discretisation.surface_triangles, len(points), CAMERA, device=device
        )
        area = tracer.trace(points).area_image(side=8)
        weights = random.normal(size=area.image.shape) if weights is None else weights
        images.append(area.image)
        gradients.append(area.pull_back(weights))
    assert (images[0] > 0.0).sum() > 500
    np.testing.assert_allclose(images[1], images[0], rtol=0, atol=1e-9)
    bound = 1e-9 * np.abs(gradients[0]).max()
    np.testing.assert_allclose(gradients[1], gradients[0], rtol=0, atol=bound)
