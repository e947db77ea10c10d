# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Signals at random moments: a command ends soon, in order, and leaves whole files or none."""

from collections.abc import Iterator
from pathlib import Path
import signal
import time

import numpy as np

from benchmarks.faults.kill import arguments_of, COMMANDS
from benchmarks.faults.outcome import Outcome
from benchmarks.faults.running import CODES, damaged_files, LIMIT, start
from benchmarks.faults.small_scene import SmallScene

SIGNALS = ('SIGINT', 'SIGTERM', 'SIGHUP', 'SIGINT twice', 'SIGSTOP', 'SIGWINCH', 'SIGPIPE')
_SOON = 10.0  # After a signal that ends a program [s].


def signal_cases(scene: SmallScene, folder: Path, count: int, seed: int) -> Iterator[Outcome]:
    """Send `count` signals; yield what came of each."""
    random = np.random.default_rng(seed)
    for number in range(count):
        command = COMMANDS[number % len(COMMANDS)]
        name = SIGNALS[int(random.integers(len(SIGNALS)))]
        after = float(random.uniform(0.0, 8.0))
        out = folder / f'signal_{number}'
        title = f'{command}: {name} after {after:.1f} s'
        yield Outcome('signal', title, *_run(command, name, after, scene, out))


def _as_in_a_terminal() -> None:
    """Ignore no signal: who runs the campaign under nohup, or behind a shell's &, ignores some."""
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)


def _run(command: str, name: str, after: float, scene: SmallScene, out: Path) -> tuple[str, str]:
    running = start(
        arguments_of(command, scene, out), out.with_suffix('.log'), preexec_fn=_as_in_a_terminal
    )
    try:
        is_over = running.ends_within(after)
        kind = signal.Signals[name.partition(' ')[0]]
        if not is_over:
            running.kill(kind)
            if name == 'SIGINT twice':
                time.sleep(0.3)
                running.kill(kind)
            if name == 'SIGSTOP':
                time.sleep(0.5)
                running.kill(signal.SIGCONT)
        ends = kind in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
        if not running.ends_within(_SOON if ends else LIMIT):
            return 'hang', running.said[-300:]
        code, said, left = running.process.returncode, running.said, running.left_running()
    finally:
        running.end()
    if 'Traceback' in said or code not in (*CODES, -kind):
        return 'traceback', f'exit code {code}: {said[-400:]}'
    if left:
        return 'left running', f'{len(left)} processes'
    if halves := damaged_files(out):
        return 'half a file', ', '.join(halves)
    return ('ended before' if is_over else 'done'), f'exit code {code}'
