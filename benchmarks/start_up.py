# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a user waits for before anything is fitted: `python benchmarks/start_up.py`.

Each program runs in a process of its own, three times, and the shortest counts; the first fit once
with no compiled kernels, then with those that it left.
"""

import os
from pathlib import Path
import resource
import subprocess
import sys
import tempfile
import time

from measuring import write

_ROOT = Path(__file__).resolve().parents[1]
_SAMPLE = _ROOT / 'bags' / 'sample'
_REPEATS = 3


def seconds(arguments: list[str], environment: dict[str, str]) -> dict[str, float]:
    """Run a program; return seconds by the clock and of the processor."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(arguments, env=environment, check=True, capture_output=True)
    clock, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {'clock_s': clock, 'cpu_s': cpu}


def main() -> None:
    """Measure, and write the figures."""
    diffcal = str(Path(sys.executable).parent / 'diffcal')
    python = [sys.executable, '-c']
    short = {
        'import diffcal_ros': [*python, 'import diffcal_ros'],
        'from diffcal_ros import calibrate': [*python, 'from diffcal_ros import calibrate'],
        'diffcal --help': [diffcal, '--help'],
    }
    own = dict(os.environ)
    figures = {
        name: min((seconds(words, own) for _ in range(_REPEATS)), key=lambda each: each['clock_s'])
        for name, words in short.items()
    }
    with tempfile.TemporaryDirectory() as folder:
        fresh = own | {'WARP_CACHE_PATH': f'{folder}/kernels'}
        fit = [diffcal, 'calibrate', str(_SAMPLE / 'bag'), '--scene', str(_SAMPLE / 'scene.yaml')]
        for name in ('first fit, no kernels compiled', 'the same again'):
            figures[name] = seconds([*fit, '--out', f'{folder}/fit'], fresh)
    for name, figure in figures.items():
        print(f'{name:36} {figure["clock_s"]:6.2f} s, processor {figure["cpu_s"]:6.2f} s')
    write('start_up', figures)


if __name__ == '__main__':
    main()
