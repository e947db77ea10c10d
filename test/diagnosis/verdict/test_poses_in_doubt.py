# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parameters are known as well as poses are, and these by what data say of their errors."""

from dataclasses import replace

from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.verdict.poses_in_doubt import with_poses_in_doubt
from diffcal_ros.rigid_transform import rotation_matrix, transform
import numpy as np
import pytest
from support.clamped_anew import rolled
from support.scenes import MODULUS

# Of poses as they are stated [m], [rad].
STATED = np.diag([0.0003**2] * 3 + [0.002**2] * 3)
ROLLS, LAYERS = (0.0, 0.8, 2.1), (8, 2, 2)


def _moved(off: np.ndarray) -> np.ndarray:
    """Turn what is 0.3 m before the camera about itself, and shift it."""
    pivot = transform(np.eye(3), np.array([0.0, 0.0, 0.3]))
    return pivot @ transform(rotation_matrix(off[3:]), off[:3]) @ np.linalg.inv(pivot)


def _fit(errors: float, covariance: np.ndarray | None = STATED):
    """Fit bodies whose poses are off by so many standard errors."""
    scene, seen = rolled(ROLLS, np.zeros((len(ROLLS), 6)), LAYERS)
    drawn = np.random.default_rng(7).standard_normal((len(seen), 6))
    drawn *= errors * np.sqrt(np.diag(STATED))
    seen = [
        replace(
            own,
            depth_from_world=_moved(off) @ own.depth_from_world,
            pose_covariance=covariance,
        )
        for own, off in zip(seen, drawn, strict=True)
    ]
    return fit_nominal(scene, seen, None)[1]


def _told(fit) -> tuple[float, float]:
    """Return by how many standard errors a modulus is off, and those."""
    found, error = fit.of_the_body(fit.parameters.names.index('youngs_modulus'))
    return (found - np.log(MODULUS)) / error, error


def test_poses_that_are_worse_than_stated_leave_the_modulus_in_doubt():
    fit = _fit(4.0)
    off, error = _told(with_poses_in_doubt(fit))
    assert error > 1.4 * _told(fit)[1]
    assert abs(off) < 2.5


@pytest.mark.slow
def test_poses_that_are_as_stated_leave_it_nearly_as_it_was():
    fit = _fit(1.0)
    assert _told(with_poses_in_doubt(fit))[1] == pytest.approx(_told(fit)[1], rel=0.25)


@pytest.mark.slow
def test_poses_that_are_known_are_in_no_doubt():
    fit = _fit(0.0, None)
    assert with_poses_in_doubt(fit) is fit
