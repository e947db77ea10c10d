# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The other direction of the gap: measured body beside the simulated one, and what hides it."""

from diffcal_ros.calibration.residuals.measured_body import measured_fractions, SimulatedView
from diffcal_ros.camera import PinholeCamera
import numpy as np
import pytest

CAMERA = PinholeCamera(260, 200, 410.0, 395.0, 131.5, 98.25)
SHAPE = (200, 260)
DISTANCE = 0.5  # [m]
# A bar along the image's rows: held on the right, free on the left.
BAR = (slice(80, 110), slice(60, 160))
HELD = (slice(80, 110), slice(140, 160))


def _simulated(bar=BAR) -> SimulatedView:
    depth = np.full(SHAPE, np.nan)
    depth[bar] = DISTANCE
    counted = np.isfinite(depth)
    counted[HELD] = False
    return SimulatedView(depth, counted, np.zeros(SHAPE, dtype=bool))


def _shares(observed: np.ndarray, simulated: SimulatedView | None = None):
    return measured_fractions(
        observed.astype(np.float32),
        simulated or _simulated(),
        CAMERA,
        truncation=0.02,
        band=3.0,
        steepest=np.deg2rad(75.0),
    )


def _measured() -> np.ndarray:
    observed = np.full(SHAPE, np.nan)
    observed[BAR] = DISTANCE + 0.001
    return observed


def test_what_is_covered_leaves_nothing() -> None:
    shares = _shares(_measured())
    assert shares.unexplained == 0.0
    assert shares.hidden == 0.0


@pytest.mark.parametrize('behind', [np.nan, 0.9])
def test_a_tip_that_sticks_out_is_unexplained(behind) -> None:
    observed = np.where(np.isfinite(_measured()), _measured(), behind)
    observed[80:110, 36:60] = DISTANCE + 0.002
    shares = _shares(observed)
    # The first pixels beside an outline are the sensor's, and the rim of the piece is a step.
    assert 0.6 * 30 * 24 < shares.unexplained <= 30 * 24
    rows, columns = np.nonzero(shares.beside)
    assert columns.max() * shares.stride < 60
    assert rows.min() * shares.stride >= 80


def test_a_fixture_on_the_clamps_side_is_not_the_body() -> None:
    observed = _measured()
    observed[50:150, 142:230] = DISTANCE - 0.004
    assert _shares(observed).unexplained == 0.0


def test_a_table_that_goes_on_is_not_the_body() -> None:
    observed = _measured()
    # It touches the bar's lower edge at the bar's own depth, and leaves the picture.
    observed[110:, :] = DISTANCE + 0.004
    assert _shares(observed).unexplained == 0.0


def test_a_cable_that_touches_is_not_the_body() -> None:
    observed = _measured()
    observed[110:160, 90:96] = DISTANCE + 0.002
    assert _shares(observed).unexplained == 0.0


def test_a_wall_behind_is_not_the_body() -> None:
    observed = np.where(np.isfinite(_measured()), _measured(), DISTANCE + 0.2)
    assert _shares(observed).unexplained == 0.0


def test_what_stands_in_front_and_goes_on_hides() -> None:
    observed = _measured()
    observed[40:160, 80:110] = DISTANCE - 0.1
    shares = _shares(observed)
    assert shares.hidden == pytest.approx(30 * 30, rel=0.1)
    assert shares.unexplained == 0.0


def test_a_body_read_too_near_is_not_hidden() -> None:
    observed = _measured()
    # A step of depth within the body's own outline, as one material may make.
    observed[80:110, 100:140] = DISTANCE - 0.03
    assert _shares(observed).hidden == 0.0


def test_a_thinned_image_tells_the_same() -> None:
    observed = np.full((800, 1040), np.nan)
    depth = np.full((800, 1040), np.nan)
    depth[320:440, 240:640] = DISTANCE
    counted = np.isfinite(depth)
    counted[:, 560:] = False
    observed[320:440, 144:640] = DISTANCE
    camera = PinholeCamera(1040, 800, 1640.0, 1580.0, 526.0, 393.0)
    shares = measured_fractions(
        observed.astype(np.float32),
        SimulatedView(depth, counted, np.zeros(depth.shape, dtype=bool)),
        camera,
        truncation=0.02,
        band=3.0,
        steepest=np.deg2rad(75.0),
    )
    assert shares.stride == 4
    assert shares.unexplained == pytest.approx(120 * 96, rel=0.15)
