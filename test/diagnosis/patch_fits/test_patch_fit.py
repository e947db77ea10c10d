# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""When a fit of patches ends: on landscapes that are as rough as patches that join and leave."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.diagnosis.patch_fits.patch_fit import AT_FIRST, FROM_A_FIT, PatchFit
from diffcal_ros.diagnosis.patches.discretisation_error import DiscretisationError
from diffcal_ros.diagnosis.patches.noise_model import NoiseModel
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.patches import Patches
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.errors import NotSimulatedError
import numpy as np
import pytest
from support.scenes import beam_scene

_NOISE = NoiseModel(pixel=0.00014, is_measured=True)
_CENTERS = 14.0 * np.stack(np.meshgrid(np.arange(6), np.arange(8)), -1).reshape(-1, 2)
# How the patches follow the logarithm of the modulus [m].
_SLOPES = 0.01 * np.linspace(0.2, 1.0, len(_CENTERS))
_ELSEWHERE = 0.002 * np.cos(np.arange(len(_CENTERS)))


class Landscape:
    """Patches whose residuals are a function of the coordinates and of how often one asked."""

    def __init__(self, values):
        self.model = SimpleNamespace(
            parameters=make_parameters(beam_scene(), ('youngs_modulus',)), at=lambda _: None
        )
        parameters = self.model.parameters.parameters[:1]
        self.model.parameters = replace(self.model.parameters, parameters=parameters)
        self.discretisation_error = DiscretisationError((), (), ())
        self.asked = 0
        self._values = values

    def groups(self, coordinates):
        self.asked += 1
        counts = np.full(len(_CENTERS), 150.0)
        patches = Patches(
            values=self._values(coordinates[0], self.asked),
            jacobian=_SLOPES[:, None].copy(),
            covariance=_NOISE.depth_covariance(_CENTERS, counts),
            centers=_CENTERS,
            cells=np.arange(len(_CENTERS)),
            weights=counts,
            common=_NOISE.depth_common(len(_CENTERS)),
        )
        nothing = np.zeros(len(_CENTERS))
        return [PatchGroup(0, 'depth', 0, patches, nothing, nothing.astype(bool))]


def run(values, most_cost=np.inf, most=30):
    landscape = Landscape(values)
    start = landscape.model.parameters.start()
    fit = PatchFit(landscape, start, Part.FIT)
    fit.run(most, most_cost)
    return landscape, fit, float(fit.here[0] - start[0])


def smooth(aim):
    first = Landscape(None).model.parameters.start()[0]
    return lambda here, _: _SLOPES * (first + aim - here) + 0.01 * _ELSEWHERE


@pytest.mark.parametrize('aim', [0.03, -0.4])
def test_a_smooth_landscape_is_followed_to_its_end(aim):
    landscape, fit, moved = run(smooth(aim))
    assert fit.is_done
    assert moved == pytest.approx(aim, abs=0.02)
    assert landscape.asked == fit.evaluations < 10


def test_a_fit_that_goes_in_circles_ends():
    # Whatever the step, some patches join and others leave: half a percent more, or less.
    landscape, fit, _ = run(
        lambda here, asked: (_ELSEWHERE + 0.3 * _SLOPES) * (1.0 + 0.002 * (-1) ** asked)
    )
    assert fit.is_done
    assert landscape.asked < 12


def test_a_fit_that_only_gets_worse_ends():
    landscape, fit, moved = run(
        lambda here, asked: (_ELSEWHERE + 0.3 * _SLOPES) * (1.0 if asked == 1 else 1.1)
    )
    assert fit.is_done or fit.is_exhausted
    assert moved == 0.0
    assert landscape.asked < 10


def test_steps_that_overshoot_are_damped_until_they_serve():
    first = Landscape(None).model.parameters.start()[0]
    # Three times as steep as the tangents say: only the fourth, damped, step gets nearer.
    _, fit, moved = run(lambda here, _: 3.0 * _SLOPES * (first + 0.1 - here) + 0.01 * _ELSEWHERE)
    assert fit.is_done
    assert moved == pytest.approx(0.1, abs=0.01)


def test_what_goes_on_need_not_find_out_anew_how_long_steps_may_be():
    first = Landscape(None).model.parameters.start()[0]

    def steep(here, _):
        return 3.0 * _SLOPES * (first + 0.1 - here) + 0.01 * _ELSEWHERE

    landscape, stopped, _ = run(steep, most=3)
    assert stopped.pace.rejections == 2
    assert stopped.pace.damping >= 1.0
    asked = []
    for pace in (AT_FIRST, stopped.pace):
        fit = PatchFit(landscape, stopped.here, Part.FIT, stopped.groups, pace)
        fit.run(30)
        assert fit.is_done
        assert fit.here[0] - first == pytest.approx(0.1, abs=0.01)
        asked.append(fit.evaluations)
    assert asked[1] == asked[0] - 2


_IS_PRECISE = np.arange(len(_CENTERS)) % 3 == 0


class UnevenLandscape(Landscape):
    """A third of the patches is precise, and others are drawn to where these do not belong."""

    def groups(self, coordinates):
        (group,) = super().groups(coordinates)
        stds = np.where(_IS_PRECISE, 1e-5, 5e-4)
        nothing = np.zeros(len(_CENTERS))
        patches = replace(
            group.patches,
            covariance=np.diag(stds**2),
            common=replace(group.patches.common, spread=nothing),
        )
        return [replace(group, patches=patches)]


@pytest.mark.parametrize(('pace', 'is_kept'), [(FROM_A_FIT, True), (AT_FIRST, False)])
def test_what_begins_where_a_fitted_model_is_does_not_walk_away_from_there(pace, is_kept):
    first = Landscape(None).model.parameters.start()[0]
    drawn = np.where(_IS_PRECISE, 0.0, 0.5)
    landscape = UnevenLandscape(lambda here, _: _SLOPES * (first + drawn - here))
    fit = PatchFit(landscape, np.array([first]), Part.FIT, pace=pace)
    begun = fit.pace
    fit.run(2)
    moved = float(fit.here[0] - first)
    assert begun == pace
    assert (abs(moved) < 1e-3) == is_kept
    assert fit.pace.is_close == is_kept, 'it is fitted on likewise'


def test_one_that_wants_to_go_far_does_not_keep_the_others():
    """An edge that is far off its prior would go by 25 times its longest step."""
    landscape = Landscape(smooth(0.3))
    parameters = make_parameters(beam_scene(), ('youngs_modulus',))
    landscape.model.parameters = replace(parameters, parameters=parameters.parameters[:2])
    one = landscape.groups

    def both(coordinates):
        (group,) = one(coordinates)
        own = 0.05 * _ELSEWHERE
        patches = replace(
            group.patches,
            values=group.patches.values + 50.0 * own,
            jacobian=np.column_stack([group.patches.jacobian[:, 0], own]),
        )
        return [replace(group, patches=patches)]

    landscape.groups = both
    fit = PatchFit(landscape, landscape.model.parameters.start(), Part.FIT)
    first = fit.here.copy()
    fit.run(2)
    moved = np.abs(fit.here - first)
    assert moved[0] == pytest.approx(0.3, abs=0.02)


def _losing(landscape, is_lost):
    """Let a landscape have no patches, wherever that is so of the modulus and of how often."""
    seen = landscape.groups

    def groups(coordinates):
        found = seen(coordinates)
        if not is_lost(coordinates[0], landscape.asked):
            return found
        none = np.zeros(0, dtype=int)
        lost = [(group, group.patches.chosen(none)) for group in found]
        return [
            replace(group, patches=own, mesh=group.mesh[none], is_report=group.is_report[none])
            for group, own in lost
        ]

    landscape.groups = groups
    return landscape


def test_a_start_at_which_nothing_is_seen_is_none():
    landscape = _losing(Landscape(smooth(0.3)), lambda *_: True)
    with pytest.raises(NotSimulatedError, match='no patch shows the body'):
        PatchFit(landscape, landscape.model.parameters.start(), Part.FIT)


def test_a_step_to_where_nothing_is_seen_is_shortened():
    landscape = _losing(Landscape(smooth(0.3)), lambda _, asked: asked == 2)
    fit = PatchFit(landscape, landscape.model.parameters.start(), Part.FIT)
    first = fit.here[0]
    fit.run(2)
    assert fit.rejections == 1
    fit.run(30)
    assert fit.is_done
    assert fit.here[0] - first == pytest.approx(0.3, abs=0.02)


def creeps(here, asked):
    return (3.0 * _ELSEWHERE + 0.1 * _SLOPES) * 0.97**asked


def test_what_will_hardly_reach_its_rivals_is_given_up():
    landscape, fit, _ = run(creeps, most_cost=10.0)
    assert landscape.asked == 3
    assert not fit.is_done
    assert fit.cost > 10.0
    # In reach, it goes on.
    landscape, _, _ = run(creeps, most_cost=1e6)
    assert landscape.asked > 10


def test_large_promises_are_not_given_up():
    _, fit, moved = run(smooth(0.4), most_cost=200.0)
    assert fit.is_done
    assert moved == pytest.approx(0.4, abs=0.02)


class FarLandscape(Landscape):
    """Patches that are found only from where the model was asked before, as a body far bent is."""

    def __init__(self, values):
        super().__init__(values)
        self.places = []
        self.model.at = self._go
        self.model.is_moving = False

    def _go(self, coordinates):
        self.places.append(float(coordinates[0]))

    def groups(self, coordinates):
        if not self.places:
            raise NotSimulatedError('not found from rest')
        return super().groups(coordinates)


@pytest.mark.parametrize(('places', 'expected'), [([], 1), ([0.0], 0)])
def test_a_fit_that_goes_on_goes_first_to_where_another_one_stood(places, expected):
    """Once, and only where a step was not found at once."""
    start = Landscape(None).model.parameters.start()
    known = Landscape(smooth(0.03)).groups(start)
    evaluator = FarLandscape(smooth(0.03))
    evaluator.places += places
    found = PatchFit(evaluator, start, Part.FIT, known)
    found.run(12)
    assert evaluator.places == [*places, *([float(start[0])] * expected)]
    assert found.is_done
    assert found.here[0] - start[0] == pytest.approx(0.03, abs=0.02)
