# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Kill commands and nodes at random moments: files whole or none, reruns right, nobody left.

    python -m benchmarks.faults.kill [--each 16] [--nodes 36] [--commands NAME ..] [--seed 7]

A command is killed again and again with one folder for its results, and run to its end in between.
Prints every fault, writes benchmarks/results/kill.json, and exits with 1 when there was one.
"""

import argparse
from collections import Counter
from collections.abc import Iterator
import json
from pathlib import Path
import shutil
import sys
import tempfile
import time
from typing import Any

import numpy as np

from benchmarks.faults.running import damaged_files, LIMIT, start
from benchmarks.faults.small_scene import make_small_scene, SmallScene
from benchmarks.measuring import write

COMMANDS = ('calibrate', 'diagnose', 'reproduce', 'simulate')
# After so many kills a command is run to its end.
_REST = 8
# What a run cannot repeat: when, how long, and where.
_VOLATILE = ('seconds', 'second', 'date', 'created', 'duration', 'took', 'path', 'version', 'time')
_PATIENCE = 10.0  # For those that a killed program started to end [s].
# Of numbers that several processes make: the order of sums.
_REPEATS = 1e-6


def arguments_of(command: str, scene: SmallScene, out: Path) -> list[str]:
    """Return the words of a command that writes to a folder."""
    given: dict[str, list[Any]] = {
        'calibrate': ['--scene', scene.scene, '--no-search', '--no-mesh-error'],
        'diagnose': ['--scene', scene.scene, '--jobs', 2],
        'reproduce': [scene.row, '--starts', 2],
        'simulate': [scene.true_scene, '--frames', 2, '--color-frames', 1, '--overwrite'],
    }
    return [str(word) for word in (command, *given[command], '--out', out)]


def kill_command(
    command: str, scene: SmallScene, folder: Path, count: int, random: np.random.Generator
) -> Iterator[tuple[str, str]]:
    """Kill a command at `count` random moments; yield what came of each: a kind and details."""
    whole, out, log = folder / 'whole', folder / 'out', folder / 'log'
    begun = time.monotonic()
    code = _run_to_its_end(command, scene, whole, log)
    seconds = time.monotonic() - begun
    for number in range(count):
        share = float(random.random())
        running = start(arguments_of(command, scene, out), log)
        try:
            is_early = running.ends_within(share * seconds)
            running.kill()
            running.ends_within(LIMIT)
            left, halves = running.left_running(_PATIENCE), damaged_files(out)
        finally:
            running.end()
        at = f'{command} killed at {share:.2f} of {seconds:.0f} s'
        if left:
            yield 'left running', f'{at}: {len(left)} processes'
        elif halves:
            yield 'half a file', f'{at}: {", ".join(halves)}'
        else:
            yield ('ended before' if is_early else 'killed'), at
        if is_early:
            # An experiment that is done is not done again: begin anew.
            shutil.rmtree(out, ignore_errors=True)
        if number % _REST == _REST - 1 or number == count - 1:
            yield _rerun(command, scene, (whole, out), log, code)


def _rerun(
    command: str, scene: SmallScene, folders: tuple[Path, Path], log: Path, code: int
) -> tuple[str, str]:
    whole, out = folders
    found = _run_to_its_end(command, scene, out, log)
    if found != code:
        return 'rerun wrong', f'{command}: exit code {found}, not {code}: {log.read_text()[-500:]}'
    hidden = [path.name for path in out.rglob('.*')] + [
        path.name for path in out.parent.glob('.*')
    ]
    if hidden:
        return 'leftovers', f'{command}: {", ".join(hidden[:5])}'
    differing = [
        path.name
        for path in whole.glob('*.json')
        if not alike(json.loads(path.read_text()), json.loads((out / path.name).read_text()))
    ]
    if differing:
        return 'rerun wrong', f'{command}: other figures in {", ".join(differing)}'
    return 'rerun right', command


def _run_to_its_end(command: str, scene: SmallScene, out: Path, log: Path) -> int:
    running = start(arguments_of(command, scene, out), log)
    try:
        if not running.ends_within(LIMIT):
            raise TimeoutError(f'{command} did not end within {LIMIT:g} s: {running.said[-500:]}')
        return int(running.process.returncode)
    finally:
        running.end()


def alike(one: Any, other: Any) -> bool:
    """Compare documents; what a run cannot repeat is left out."""
    if isinstance(one, dict) and isinstance(other, dict):
        names = {name for name in (*one, *other) if not _is_volatile(name)}
        return all(
            name in one and name in other and alike(one[name], other[name]) for name in names
        )
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, float) and isinstance(other, int | float):
        return bool(np.isclose(one, other, rtol=_REPEATS, atol=1e-12, equal_nan=True))
    if isinstance(one, str) and isinstance(other, str) and ('/' in one or ' s' in one):
        return True  # A path, or how long something took.
    return bool(one == other)


def _is_volatile(name: str) -> bool:
    return any(word in name.lower() for word in _VOLATILE)


def main() -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--each', type=int, default=16, help='kills of each command')
    parser.add_argument('--commands', nargs='*', default=COMMANDS, choices=COMMANDS)
    parser.add_argument('--nodes', type=int, default=36, help='kills of nodes')
    parser.add_argument('--seed', type=int, default=7)
    parser.add_argument('--name', default='kill', help='of the file with the results')
    given = parser.parse_args()
    outcomes: list[tuple[str, str]] = []
    with tempfile.TemporaryDirectory() as name:
        scene = make_small_scene(Path(name) / 'scene')
        for command in given.commands:
            folder = Path(name) / command
            folder.mkdir()
            random = np.random.default_rng((given.seed, COMMANDS.index(command)))
            for outcome in kill_command(command, scene, folder, given.each, random):
                outcomes.append(outcome)
                print(*outcome, flush=True)
        if given.nodes:
            from benchmarks.faults.kill_nodes import kill_nodes

            random = np.random.default_rng((given.seed, len(COMMANDS)))
            for outcome in kill_nodes(scene, Path(name) / 'nodes', given.nodes, random):
                outcomes.append(outcome)
                print(*outcome, flush=True)
    counts = Counter(kind for kind, _ in outcomes)
    faults = [list(one) for one in outcomes if one[0] not in GOOD]
    write(given.name, {'seed': given.seed, 'outcomes': dict(counts), 'faults': faults})
    return 1 if faults else 0


GOOD = ('killed', 'ended before', 'rerun right')


if __name__ == '__main__':
    sys.exit(main())
