# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Pulls of pixels and of the outline are the transposes of the pushes."""

from diffcal_ros.depth.trace import Trace
from diffcal_ros.depth.tracer import DepthTracer
import numpy as np
import pytest
from support.views import bent_beam, CAMERA, tilted_view

# Sums of some thousand products in another order.
_ROUNDING = 1e-10


@pytest.fixture(params=[2.0, 7.0], ids=['plain', 'self-occluded'])
def trace(request) -> Trace:
    points, triangles = bent_beam(request.param)
    return DepthTracer(triangles, len(points), CAMERA).trace(tilted_view(points))


def _motion(trace: Trace, random) -> np.ndarray:
    return random.normal(size=(3, len(trace.points), 3))


def test_depth(trace: Trace, random) -> None:
    pixels = np.flatnonzero(trace.faces.ravel() >= 0).astype(np.int32)
    weights, motion = random.normal(size=len(pixels)), _motion(trace, random)
    forward = weights @ trace.push_depth(pixels, motion)
    backward = (trace.pull_depth(pixels, weights) * motion).sum(axis=(1, 2))
    np.testing.assert_allclose(backward, forward, rtol=_ROUNDING)


def test_outline(trace: Trace, random) -> None:
    segments = trace.outline.segments
    weights, motion = random.normal(size=len(segments)), _motion(trace, random)
    forward = weights @ trace.push_outline(segments, motion)
    backward = (trace.pull_outline(segments, weights) * motion).sum(axis=(1, 2))
    np.testing.assert_allclose(backward, forward, rtol=_ROUNDING)
