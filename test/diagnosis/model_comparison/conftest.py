# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models of a tilted beam, and of one that was clamped anew for each of three poses."""

from diffcal_ros.diagnosis.model_comparison import looks_in_any_form
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.screening.candidates import candidates
import pytest
from support.clamped_anew import CLAMP, clamped_anew
from support.judged_models import refitted_with


@pytest.fixture
def pool(screened):
    """Who refits models of the tilted beam."""
    evaluator, nominal, _ = screened
    with RefitPool(evaluator, nominal, lambda _: None) as found:
        yield found


@pytest.fixture(scope='session')
def tilted(screened):
    """That beam with a tilt, refitted."""
    return refitted_with(screened, 'gravity_tilt')


@pytest.fixture(scope='session')
def pair(screened):
    """The same with an error of depth beside the tilt."""
    return refitted_with(screened, 'gravity_tilt', 'depth_affine')


@pytest.fixture(scope='session')
def anew_pool():
    """Who refits models of the beam that was clamped anew."""
    return RefitPool(*fit_nominal(*clamped_anew(), None))


@pytest.fixture(scope='session')
def anew_request(anew_pool):
    """A clamp that is free to be another one in each pose."""
    listed = candidates(anew_pool.nominal.model.scene)
    own = next(c for c in listed if (c.identifier, c.components) == ('clamp_offset', CLAMP))
    parts = looks_in_any_form.in_each_pose(anew_pool, own)
    assert [part.name for part in parts] == [f'{n}@{p}' for n in own.names for p in range(3)]
    return looks_in_any_form._freed(own, parts, 8)


@pytest.fixture(scope='session')
def anew_clamp(anew_pool, anew_request):
    """The same, refitted."""
    (found,) = anew_pool.refit_all([anew_request])
    return found
