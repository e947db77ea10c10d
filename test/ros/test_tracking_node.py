# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two nodes and DDS: a recording in a loop is followed, and its changes are told."""

from dataclasses import replace

from diagnostic_msgs.msg import DiagnosticArray
from diffcal_ros.ros.calibration import CalibrationNode
from diffcal_ros.ros.conversion import stamp_ns
from diffcal_ros.ros.depth_source import DepthSourceNode
from diffcal_ros.ros.qos import LATCHED
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.changing_body import BodyState, record_changes
from diffcal_ros.synthetic.filming import Timing
import pytest
from support.recorded_beam import MODULUS, SETTINGS, write_beam_scene

RATE = 30.0
STEP = 1.3
SECONDS = 10
# As fast as life: whoever follows a camera keeps up with it.
PACE = 1.0
_LIMIT = 300.0  # Kernels may have to be compiled [s].


@pytest.fixture(scope='module')
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp('changing')
    scene = load_scene(
        write_beam_scene(folder / 'true', {'marker': ..., 'mesh.element': 'linear'})
    )
    settings = replace(
        SETTINGS,
        timing=Timing(int(RATE) * SECONDS // 2, RATE),
        color_frames=0,
        element=scene.element,
    )
    return record_changes(scene, folder / 'out', (BodyState(), BodyState(STEP)), settings)


def _values(status):
    return {pair.key: pair.value for pair in status.values}


@pytest.mark.slow
def test_a_loop_of_ten_seconds_is_followed_through_its_steps(recorded, make_bench):
    bench = make_bench(
        {
            'scene': recorded,
            'pose_source': 'stored',
            'mesh_error': False,
            'window.frames': 5,
            'bag': recorded.parent / 'bag',
            'loop': True,
            'rate': PACE,
            'wait_for_subscriber': 60.0,
        }
    )
    estimates = bench.collect(DiagnosticArray, 'calibration/estimates', 100)
    changes = bench.collect(DiagnosticArray, 'calibration/change', LATCHED)
    calibration = bench.add(CalibrationNode)
    bench.status('calibration: fit', b'\x01', 'waiting for depth/image_rect_raw')
    bench.add(DepthSourceNode)
    # Up in mid-recording, down when it begins anew, and up again.
    bench.until(lambda: len(changes) >= 3, 'three changes', _LIMIT)
    for place, change in enumerate(changes[:3]):
        modulus = _values(next(s for s in change.status if s.name == 'youngs_modulus'))
        low, high = sorted((float(modulus['before']), float(modulus['after'])))
        assert high / low == pytest.approx(STEP, rel=0.05)
        assert _values(change.status[0])['number'] == str(place + 1)
    told = [
        (stamp_ns(message.header.stamp), {s.name: _values(s) for s in message.status})
        for message in estimates
    ]
    tracked = [(stamp, found) for stamp, found in told if found['fit']['outcome'] == 'tracking']
    stamps = [stamp for stamp, _ in tracked]
    assert stamps == sorted(stamps), 'stamps go on'
    assert stamps[-1] - stamps[0] > SECONDS * 1e9
    moduli = [float(found['youngs_modulus']['value']) for _, found in tracked]
    near = [
        min(abs(modulus / (factor * MODULUS) - 1.0) for factor in (1.0, STEP))
        for modulus in moduli
    ]
    # Never an average of both.
    assert max(near) < 0.05
    health = bench.health['calibration: fit']
    assert 'tracking, the body changed' in health.message
    # How many frames were used is a matter of the machine; none was told of that was not.
    bench.until(
        lambda: int(bench.value('calibration: fit', 'frames used') or 0) >= len(tracked), 'count'
    )
    assert calibration.get_parameter('refit').value == 'tracking'
