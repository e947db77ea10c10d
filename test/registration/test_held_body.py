# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The body that a part holds, as it may hang."""

from diffcal_ros.registration.held_body import BodyAtRest
import numpy as np

from .conftest import make_part, make_picture


def body() -> BodyAtRest:
    return make_picture('block', seed=1, has_body=False).body


def test_the_root_is_what_leaves_the_part():
    own = body()
    root = own.root(make_part('block').positions[make_part('block').triangles].mean(axis=1))
    middles = own.positions[own.triangles].mean(axis=1)
    assert 0 < root.sum() < len(root)
    assert middles[root, 0].max() < 0.05


def test_a_hanging_body_keeps_its_length_and_bends_along_gravity():
    own = body()
    root = own.positions[own.triangles].mean(axis=1)[:, 0] < 0.01
    shapes = own.hanging(root)
    assert len(shapes) == 10
    np.testing.assert_allclose(shapes[0], own.positions, atol=1e-6)
    tip = own.positions[:, 0] > 0.119
    ends = np.array([shape[tip].mean(axis=0) for shape in shapes])
    assert (np.diff(ends[:, 1]) < 0.0).all()
    np.testing.assert_allclose(ends[:, 2], ends[0, 2], atol=1e-12)
    # Sections stay as wide as they were.
    for shape in shapes:
        section = shape[tip] - shape[tip].mean(axis=0)
        rest = own.positions[tip] - own.positions[tip].mean(axis=0)
        np.testing.assert_allclose(
            np.linalg.norm(section, axis=1), np.linalg.norm(rest, axis=1), atol=1e-9
        )


def test_gravity_that_is_not_known_or_along_the_body_bends_nothing():
    own = body()
    root = own.positions[own.triangles].mean(axis=1)[:, 0] < 0.01
    for gravity in (None, np.zeros(3)):
        assert BodyAtRest(own.positions, own.triangles, gravity).hanging(root) == []
    middles = own.positions[own.triangles].mean(axis=1)
    along = middles[~root].mean(axis=0) - middles[root].mean(axis=0)
    assert BodyAtRest(own.positions, own.triangles, along).hanging(root) == []
