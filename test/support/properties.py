# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How property tests are run: the same cases each time, however slow the machine is."""

import pytest

hypothesis = pytest.importorskip('hypothesis', reason='hypothesis is not installed')


def many(max_examples):
    """Return settings for so many cases, drawn alike in every run."""
    return hypothesis.settings(
        max_examples=max_examples,
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=[
            hypothesis.HealthCheck.function_scoped_fixture,
            hypothesis.HealthCheck.too_slow,
        ],
    )
