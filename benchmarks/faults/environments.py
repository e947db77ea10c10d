# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Odd machines: no home, no room, no locale, no output; a command works or says why not."""

from collections.abc import Callable, Iterator
import itertools
import os
from pathlib import Path
import resource
import shutil
from typing import Any

import numpy as np

from benchmarks.faults.outcome import Outcome
from benchmarks.faults.running import CODES, damaged_files, LIMIT, start
from benchmarks.faults.small_scene import SmallScene

_MEGABYTE = 1 << 20
_NO_MEMORY = 70  # With a sentence that says so; of anything else it is a fault.


def _limit(what: int, amount: int) -> Callable[[], None]:
    return lambda: resource.setrlimit(what, (amount, amount))


# Of the variables: another value, or None: not there. {folder} is one that is the case's own.
VARIABLES: dict[str, dict[str, str | None]] = {
    'nothing odd': {},
    'no home': {'HOME': None},
    'a home that is not there': {'HOME': '{folder}/nowhere'},
    'a home that is a file': {'HOME': '{folder}/file'},
    'an empty home': {'HOME': ''},
    'a cache that is a file': {'XDG_CACHE_HOME': '{folder}/file', 'HOME': '{folder}/file'},
    'a device as cache': {'XDG_CACHE_HOME': '/dev/null'},
    'a file as cache of kernels': {'WARP_CACHE_PATH': '{folder}/file'},
    'a file as folder of plots': {'MPLCONFIGDIR': '{folder}/file'},
    'settings of plots that are none': {'MATPLOTLIBRC': '{folder}/file'},
    'no folder for temporary files': {'TMPDIR': '{folder}/nowhere'},
    'plain ASCII': {'LC_ALL': 'C', 'PYTHONIOENCODING': 'ascii', 'PYTHONUTF8': '0'},
    'an unknown locale': {'LC_ALL': 'xx_YY.UTF-99'},
    'no terminal': {'TERM': None, 'COLUMNS': '0', 'LINES': '0'},
    'a terminal of one column': {'COLUMNS': '1'},
    'threads in words': {'OMP_NUM_THREADS': 'many'},
    'no threads': {'OMP_NUM_THREADS': '0'},
    'a thousand threads': {'OMP_NUM_THREADS': '1000'},
    'another back end of plots': {'MPLBACKEND': 'nonsense'},
    'the back end of a notebook': {'MPLBACKEND': 'module://matplotlib_inline.backend_inline'},
    'a GPU that is not there': {'CUDA_VISIBLE_DEVICES': '99'},
    'no path': {'PATH': ''},
    'warnings are errors of others': {'PYTHONWARNINGS': 'error::FutureWarning'},
    'optimised': {'PYTHONOPTIMIZE': '2'},
    'a random order of sets': {'PYTHONHASHSEED': '{number}'},
}
LIMITS: dict[str, Callable[[], None]] = {
    'files of 100 kB': _limit(resource.RLIMIT_FSIZE, 100_000),
    'no file may grow': _limit(resource.RLIMIT_FSIZE, 0),
    'sixteen open files': _limit(resource.RLIMIT_NOFILE, 16),
    'no core': _limit(resource.RLIMIT_CORE, 0),
    'a gigabyte of memory': _limit(resource.RLIMIT_AS, 1024 * _MEGABYTE),
    'a gigabyte and a half': _limit(resource.RLIMIT_AS, 1536 * _MEGABYTE),
    'no permissions for others': lambda: (os.umask(0o777), None)[1],
}
STREAMS = ('closed input', 'closed output', 'full output', 'full errors', 'nobody reads')
COMMANDS = ('check', 'calibrate', 'simulate', 'suggest')
PLACES = ('a folder that is gone', 'results in a file', 'results in /dev/null', 'results nowhere')


def environment_cases(scene: SmallScene, folder: Path, count: int, seed: int) -> Iterator[Outcome]:
    """Run commands in `count` odd environments; yield what came of each.

    Every command meets every environment once before any of them again.
    """
    pairs = list(itertools.product(COMMANDS, [*VARIABLES, *LIMITS, *STREAMS, *PLACES]))
    order = np.random.default_rng(seed).permutation(len(pairs))
    for number, place in enumerate(itertools.islice(itertools.cycle(order), count)):
        command, name = pairs[place]
        own = folder / f'case_{number}'
        own.mkdir()
        (own / 'file').write_text('a file\n')
        yield Outcome(
            'environment', f'{command}: {name}', *_run(command, name, scene, own, number)
        )
        shutil.rmtree(own, ignore_errors=True)


def _run(command: str, name: str, scene: SmallScene, folder: Path, number: int) -> tuple[str, str]:
    out = {
        'results in a file': folder / 'file',
        'results in /dev/null': Path('/dev/null'),
        'results nowhere': folder / 'file' / 'below',
    }.get(name, folder / 'out')
    words: dict[str, list[Any]] = {
        'check': [scene.scene, '--draw', folder / 'drawing.png'],
        'calibrate': [
            *('--scene', scene.scene, '--max-iterations', 1, '--no-search', '--no-mesh-error'),
            *('--out', out),
        ],
        'simulate': [scene.true_scene, '--frames', 2, '--color-frames', 1, '--out', out],
        'suggest': [scene.scene],
    }
    arguments = [str(word) for word in (command, *words[command])]
    running = start(arguments, folder / 'log', **_options(name, folder, number))
    try:
        if not running.ends_within(LIMIT):
            return 'hang', running.said[-300:]
        code, said, left = running.process.returncode, running.said, running.left_running()
    finally:
        running.end()
    if code == _NO_MEMORY and 'there was not enough memory' in said:
        return 'refused', f'exit code {code}'
    if 'Traceback' in said or code not in CODES:
        return 'traceback', f'exit code {code}: {said[-400:]}'
    if left:
        return 'left running', f'{len(left)} processes'
    if out.is_dir() and (halves := damaged_files(out)):
        return 'half a file', ', '.join(halves)
    return ('refused' if code == 2 else 'done'), f'exit code {code}'


def _options(name: str, folder: Path, number: int) -> dict[str, Any]:
    options: dict[str, Any] = {'env': dict(os.environ), 'cwd': folder}
    for key, value in VARIABLES.get(name, {}).items():
        options['env'].pop(key, None)
        if value is not None:
            options['env'][key] = value.format(folder=folder, number=number)
    if name in LIMITS:
        options['preexec_fn'] = LIMITS[name]
    if name == 'a folder that is gone':
        gone = folder / 'gone'
        gone.mkdir()
        options.update(cwd=gone, preexec_fn=lambda: os.rmdir(gone))
    closed = {'closed input': 0, 'closed output': 1}.get(name)
    if closed is not None:
        options['preexec_fn'] = lambda: os.close(closed)
    if name in ('full output', 'full errors'):
        stream = 'stdout' if name == 'full output' else 'stderr'
        options[stream] = open('/dev/full', 'wb')  # noqa: SIM115
    if name == 'nobody reads':
        reader, writer = os.pipe()
        os.close(reader)
        options['stdout'] = writer
    return options
