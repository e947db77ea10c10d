# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A beam that was clamped anew for each of three poses, and a model of it that knows of that."""

from diffcal_ros.diagnosis.diagnose import fit_nominal
from diffcal_ros.diagnosis.model_comparison import looks_in_any_form
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.screening.candidates import candidates
import pytest
from support.clamped_anew import CLAMP, clamped_anew


@pytest.fixture(scope='session')
def anew_pool():
    """Who refits models of the beam."""
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
