# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Follow a body live: 1024x768 depth at 30 Hz through DDS, two nodes, parameters out.

Build first and source install/setup.bash, as `make demo` does. A recording of ten seconds is
replayed in a loop with stamps that go on. Four streams: a body that stays the same; the same,
while somebody looks at the pictures every other ten seconds; one whose modulus goes up and down
by 30 %; and one that gets a payload. Writes results/live.json.

    python benchmarks/live.py [--seconds 300] [--short 60] [--elements linear quadratic]
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
import sys
import tempfile
from typing import Any

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.changing_body import BodyState, record_changes
from diffcal_ros.synthetic.filming import Timing
from diffcal_ros.synthetic.lidar import LidarModel
from diffcal_ros.synthetic.recorder import RecorderSettings
from live_figures import latency_figures, step_figures, stream_figures, TrueState
from live_scene import MODULUS, write_scene
from live_watch import LiveWatch
from measuring import write
import rclpy

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / 'demo'))
from node_process import join_quiet_domain, NodeGroup  # noqa: E402

_RATE, _BAG_SECONDS = 30, 10
_LOOK = 10.0  # How long somebody looks, and does not [s].
_PAYLOAD = 0.010  # [kg]
_STEPS = (BodyState(), BodyState(1.3), BodyState(), BodyState(0.7))
_LOADS = (BodyState(), BodyState(payload=_PAYLOAD))


def main() -> None:
    """Run all streams with each element asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=float, default=300.0, help='of the steady stream')
    parser.add_argument('--short', type=float, default=60.0, help='of each other stream')
    parser.add_argument('--elements', nargs='+', default=['linear', 'quadratic'])
    parser.add_argument('--streams', nargs='+', default=['steady', 'pictures', 'steps', 'payload'])
    parser.add_argument(
        '--nice', type=int, default=0, help='of the nodes; below 0 needs root, for a busy machine'
    )
    parser.add_argument('--name', default='live')
    arguments = parser.parse_args()
    join_quiet_domain()
    figures: dict[str, Any] = {'rate_hz': _RATE, 'image': '1024x768 16UC1'}
    figures['nice'] = arguments.nice
    for name in arguments.elements:
        figures[name] = {}
        for stream in arguments.streams:
            seconds = arguments.seconds if stream == 'steady' else arguments.short
            states = {'steps': _STEPS, 'payload': _LOADS}.get(stream, _STEPS[:1])
            figures[name][stream] = run(
                Element(name), states, seconds, stream == 'pictures', arguments.nice
            )
            # After every stream: what was measured is kept, whatever comes.
            write(arguments.name, figures)


def run(
    element: Element,
    states: Sequence[BodyState],
    seconds: float,
    has_onlookers: bool,
    nice: int,
) -> dict[str, Any]:
    """Replay one stream and say how it was followed."""
    rclpy.init()
    node = rclpy.create_node('live_benchmark')
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        scene = load_scene(write_scene(folder / 'true', element))
        settings = RecorderSettings(
            timing=Timing(_RATE * _BAG_SECONDS // len(states), _RATE),
            color_frames=0,
            element=element,
            lidar=LidarModel(encoding='16UC1'),
        )
        fitted = record_changes(scene, folder / 'recorded', states, settings)
        with NodeGroup(folder / 'log') as nodes:
            nodes.start('calibration', scene=fitted, pose_source='stored')
            watch = LiveWatch(node, nodes)
            watch.until(lambda: 'waiting' in watch.message, 120.0)
            nodes.start(
                'depth_source', bag=fitted.parent / 'bag', loop=True, wait_for_subscriber=60.0
            )
            for process in (nodes.process_id('calibration'), nodes.process_id('depth_source')):
                _set_nice(process, nice)
            watch.until(lambda: bool(watch.told), 120.0)
            watch.begin(nodes.process_id('calibration'))
            begun = watch.counts()
            _listen(watch, seconds, has_onlookers)
            figures = {'tets': scene.mesh.tet_count, **stream_figures(watch, begun, seconds)}
            if has_onlookers:
                figures['pictures'] = _picture_figures(watch)
            if len(states) > 1:
                truths = [_truth(state) for state in states]
                figures['changes_of_the_body'] = step_figures(
                    watch, truths, settings.timing.frames, _RATE
                )
    rclpy.shutdown()
    return figures


def _set_nice(process: int, nice: int) -> None:
    """Give a node that leads a session of its own more or less than its share of the cores."""
    if nice:
        # The scheduler of a desktop shares between sessions first, then within them.
        Path(f'/proc/{process}/autogroup').write_text(str(nice))


def _listen(watch: LiveWatch, seconds: float, has_onlookers: bool) -> None:
    if has_onlookers:
        for number in range(round(seconds / _LOOK)):
            watch.look(number % 2 == 1)
            watch.listen(_LOOK)
    else:
        watch.listen(seconds)


def _picture_figures(watch: LiveWatch) -> dict[str, Any]:
    """Compare the frames during which somebody looked with the others."""
    return {
        'received': watch.picture_count,
        'frame_to_parameters_looked_at': latency_figures(
            watch, [told for told in watch.told if told.is_looked_at]
        ),
        'frame_to_parameters_alone': latency_figures(
            watch, [told for told in watch.told if not told.is_looked_at]
        ),
    }


def _truth(state: BodyState) -> TrueState:
    if state.payload:
        return TrueState(f'{1e3 * state.payload:g} g payload', None)
    return TrueState(f'modulus x {state.factor:g}', state.factor * MODULUS)


if __name__ == '__main__':
    main()
