# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the blind generator's cameras see of a body with faults, beside one without."""

import numpy as np
from numpy.typing import NDArray
import pytest

from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.paint import FIXTURE
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.specimen import Specimen


def with_and_without(
    plain: Specimen, setup: Setup, faults: Faults, pose: int, rest: np.ndarray
) -> tuple[Rendering, Rendering, NDArray[np.bool_]]:
    """Return a view with faults of the camera, one without, and which samples see something.

    Fails where the two do not see the same.

    Args:
        plain: the body.
        setup: with its cameras.
        faults: that move no node.
        pose: number.
        rest: nodes, object frame [m], shape (N, 3).
    """
    view, right = (
        true_rendering(plain, setup, setup.observations[pose], each, rest)
        for each in (faults, Faults())
    )
    there = np.isfinite(right.depth)
    assert np.array_equal(there, np.isfinite(view.depth))
    return view, right, there


def region_errors(
    plain: Specimen, setup: Setup, faults: Faults, pose: int, rest: np.ndarray
) -> np.ndarray:
    """Return which part of a region's error each sample of a body has, shape (S,).

    Fails where the fixture's depths err. The arguments are those of `with_and_without`.
    """
    view, right, there = with_and_without(plain, setup, faults, pose, rest)
    error = (view.depth[there] - right.depth[there]) / (1e-3 * faults.region_bias)
    is_body = right.labels[there] != FIXTURE
    assert np.abs(error[~is_body]).max() == pytest.approx(0.0, abs=1e-9)
    return np.asarray(error[is_body])


def spread_of_what_stays(
    seen: tuple[Rendering, Rendering, np.ndarray], told: dict[tuple[int, int], float]
) -> float:
    """Check that errors are the same at a place of the picture in all poses; return their spread.

    Args:
        seen: see `with_and_without`.
        told: by place, what earlier poses erred by [mm]; this one's are added.

    Returns:
        What is between the least and the largest error [mm].
    """
    view, right, there = seen
    errors = np.zeros(there.shape)
    errors[there] = 1e3 * (view.depth[there] - right.depth[there])
    rows, columns, samples = np.nonzero(there)
    for row, column, sample in zip(rows[::50], columns[::50], samples[::50], strict=True):
        error = errors[row, column, sample]
        place = (int(row) + view.row, int(column) + view.column)
        assert told.setdefault(place, error) == pytest.approx(error, abs=1e-9)
    return float(np.ptp(errors[there]))
