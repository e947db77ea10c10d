# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two nodes and DDS: a body that is let go again and again is fitted swing by swing."""

from diagnostic_msgs.msg import DiagnosticArray
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.ros.calibration import CalibrationNode
from diffcal_ros.ros.depth_source import DepthSourceNode
from diffcal_ros.synthetic.filming import Timing
import pytest
from support.released_beam import DAMPING, record_release

MODULUS = 200e3
REST, SWING = 0.6, 0.7  # [s]
_LIMIT = 300.0  # Kernels may have to be compiled [s].


@pytest.fixture(scope='module')
def released(tmp_path_factory):
    changes = {
        'marker': ...,
        'mesh.element': 'linear',
        'motion.at': {'start': REST, 'min': 0.5, 'max': 0.7},
        'motion.duration': 0.6,
        'regions.body.density': 1080,
        'fit': ['youngs_modulus', 'damping', 'release_time'],
    }
    return record_release(
        tmp_path_factory.mktemp('released'),
        changes,
        Timing(round(30 * (REST + SWING))),
        color_frames=0,
        element=Element.LINEAR,
    )


def _values(status):
    return {pair.key: pair.value for pair in status.values}


@pytest.mark.slow
def test_a_loop_of_releases_is_fitted_again_and_again(released, make_bench):
    bench = make_bench(
        {
            'scene': released.scene,
            'pose_source': 'stored',
            'mesh_error': False,
            'bag': next(iter(released.bags.values())),
            'loop': True,
            'wait_for_subscriber': 60.0,
        }
    )
    estimates = bench.collect(DiagnosticArray, 'calibration/estimates', 100)
    bench.add(CalibrationNode)
    bench.status('calibration: fit', b'\x01', 'waiting for depth/image_rect_raw')
    bench.add(DepthSourceNode)

    def ends():
        told = [{s.name: _values(s) for s in message.status} for message in estimates]
        return [one for one in told if one['fit']['outcome'] == 'converged']

    first, second = bench.until(lambda: ends()[:2] if len(ends()) > 1 else None, 'fits', _LIMIT)
    for end in (first, second):
        assert float(end['youngs_modulus']['value']) == pytest.approx(MODULUS, rel=0.03)
        assert float(end['damping']['value']) == pytest.approx(DAMPING, rel=0.10)
        assert 0.0 < float(end['youngs_modulus']['std_error']) < 0.2 * MODULUS
    bench.until(lambda: int(bench.value('calibration: fit', 'swings fitted') or 0) >= 2, 'count')
    seen, fitted, skipped = (
        int(bench.value('calibration: fit', f'swings {what}'))
        for what in ('seen', 'fitted', 'skipped')
    )
    # One may be in the works, and one may wait.
    assert 0 <= seen - fitted - skipped <= 2
    assert bench.value('calibration: fit', 'changes') == '0'
