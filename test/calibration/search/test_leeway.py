# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where an answer could not be used, stated placements give way until noise is known."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import PLACING
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.residual_scales import Scales
from diffcal_ros.calibration.search.global_search import GlobalSearch
from diffcal_ros.calibration.search.posed_shapes import CoarseObjective, PosedShapes
from diffcal_ros.scene.model import PoseSetup, Scene
import numpy as np
import pytest
from support.scenes import beam_scene, observation, true_depth

LEEWAY = Scales(leeway=3.0)


def _scene(modulus: float = 60e3) -> Scene:
    scene = beam_scene((4, 2, 2), modulus=modulus, fit=('youngs_modulus', 'rigid_offset'))
    (setup,) = scene.observations
    pose = PoseSetup(position_std=0.002, rotation_std=0.01)
    return replace(scene, observations=(replace(setup, pose=pose),))


def _objective() -> RobustObjective:
    return Calibration(_scene(), [observation(true_depth())]).likelihood('a test')


def test_deviations_count_more_for_what_places_the_body_alone() -> None:
    """Also where a pose has a covariance with correlations."""
    root = np.diag([1e-3] * 3 + [1e-2] * 3)
    root[0, 4] = root[4, 0] = 2e-3
    parameters = make_parameters(_scene(), pose_covariances=[root @ root])
    stated, wide = parameters.prior(), parameters.prior(leeway=3.0)
    places = np.array([own.kind in PLACING for own in parameters])
    assert places.sum() == 12
    assert not places.all()
    np.testing.assert_array_equal(wide.mean, stated.mean)
    inside, outside = np.ix_(places, places), np.ix_(~places, ~places)
    np.testing.assert_allclose(9.0 * wide.precision[inside], stated.precision[inside])
    np.testing.assert_array_equal(wide.precision[outside], stated.precision[outside])


def test_cost_and_slope_differ_by_what_is_stated_of_the_placement() -> None:
    firm = _objective()
    loose, parameters = firm.under(LEEWAY), firm.model.parameters
    here = parameters.start() + np.linspace(0.001, 0.02, len(parameters))
    stated, wide = parameters.prior(), parameters.prior(leeway=3.0)
    between = stated.cost(here) - wide.cost(here)
    assert between > 0.1
    assert firm.cost(here) - loose.cost(here) == pytest.approx(between, rel=1e-9)
    slopes = firm.linearise(here).negative_gradient - loose.linearise(here).negative_gradient
    np.testing.assert_allclose(slopes, stated.pull(here) - wide.pull(here), rtol=1e-6, atol=1e-6)


def test_leeway_ends_with_the_first_refinement() -> None:
    """Annealing keeps it; no fit ends with it, whether or not its noise became finer."""
    objective = _objective().under(LEEWAY)
    here = objective.model.parameters.start()
    while not objective.is_annealed:
        objective.anneal(here)
        assert objective.scales.leeway == 3.0
    assert objective.refine(here)
    assert objective.scales.leeway == 1.0
    finest = replace(objective.scales, leeway=3.0)
    for kind in ('depth', 'edge'):
        finest = replace(finest, **{kind: replace(getattr(finest, kind), noise=1e-9)})
    nothing_finer = objective.under(finest)
    assert nothing_finer.refine(here)
    assert nothing_finer.scales == replace(finest, leeway=1.0)


def test_a_coarse_comparison_keeps_its_leeway_to_the_end() -> None:
    scene, seen = _scene(), [observation(true_depth())]
    parameters = make_parameters(scene)
    model = PosedShapes(scene, seen, parameters)
    coarse = CoarseObjective(model, 1, device='cpu')
    here = parameters.start()
    shape = model.worlds(here)
    loose = coarse.of_shape(shape, 3.0)
    loose.anneal(here)
    assert loose.at_the_end().scales.leeway == 3.0
    assert coarse.of_shape(shape).scales.leeway == 1.0
    assert coarse.scales.leeway == 1.0


@pytest.fixture
def searches(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Notes the leeway of every search."""
    noted: list[float] = []
    whole = GlobalSearch.basins

    def basins(self: GlobalSearch, leeway: float = 1.0):
        noted.append(leeway)
        return whole(self, leeway)

    monkeypatch.setattr(GlobalSearch, 'basins', basins)
    return noted


@pytest.mark.slow
def test_an_answer_that_may_be_used_is_taken_as_it_is(searches: list[float]) -> None:
    assert Calibration(_scene(90e3), [observation(true_depth())]).run().outcome.exit_code == 0
    assert searches == [1.0]


@pytest.mark.slow
def test_one_that_may_not_is_looked_for_again(searches: list[float]) -> None:
    """Half of the measured body is missing here, which no placement mends."""
    depth = true_depth()
    depth[:, : depth.shape[1] // 2] = np.nan
    fit = Calibration(_scene(90e3), [observation(depth)])
    assert fit.run().outcome.exit_code != 0
    assert searches == [1.0, 3.0]
