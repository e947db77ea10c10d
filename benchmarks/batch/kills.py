# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A batch whose workers and master are killed at random: what is lost, what is done twice."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from typing import Any

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.batch.job import MARK
from diffcal_ros.batch.run import FOLDER
import numpy as np

CODE = 'import sys; from diffcal_ros.cli.main import main; sys.exit(main(sys.argv[1:]))'
KEPT = 'kills.json'
# Parts of a result that tell when it was found, not what.
_OF_THE_RUN = ('seconds', 'history')
# How long after a body is done a kill comes at most [s], and how often is looked.
_BLUR, _TICK = 5.0, 0.2


@dataclass
class Kills:
    """What was killed, and what became of the bodies.

    Attributes:
        workers: processes killed.
        masters: masters killed.
        runs: of the command.
        changed: results that were there and were written again.
        seen: inode and time of each result's mark, by body.
    """

    workers: int = 0
    masters: int = 0
    runs: int = 0
    changed: int = 0
    seen: dict[str, tuple[int, int]] = field(default_factory=dict)

    def keep(self, file: Path) -> None:
        """Write them, for a benchmark that is stopped goes on later."""
        write_text_atomically(file, json.dumps(asdict(self)) + '\n')

    @classmethod
    def read(cls, file: Path) -> 'Kills':
        """Read what was kept; nothing was killed yet where there is no file."""
        if not file.is_file():
            return cls()
        content = json.loads(file.read_text())
        seen = {name: tuple(state) for name, state in content.pop('seen').items()}
        return cls(**content, seen=seen)

    def look(self, out: Path) -> None:
        """Compare the marks of what is done with those that were there before."""
        for mark in (out / FOLDER).glob(f'[!.]*/{MARK}'):
            found = mark.stat()
            state = (found.st_ino, found.st_mtime_ns)
            self.changed += self.seen.setdefault(mark.parent.name, state) != state


def run_killed(
    command: list[str],
    out: Path,
    *,
    between: tuple[int, int],
    seed: int,
    workers_of: Callable[[int], list[int]],
    say: Callable[[str], None] = print,
) -> Kills:
    """Run a batch until it is done, and kill a worker or the master again and again.

    Args:
        command: arguments of `diffcal`.
        out: folder of the batch.
        between: fewest and most bodies that are done between two kills; times would depend on
            what else the machine does.
        seed: of times and victims.
        workers_of: returns the numbers of the workers of a master.
        say: told of every kill.
    """
    file = out / KEPT
    kills = Kills.read(file)
    random = np.random.default_rng([seed, kills.runs])
    while True:
        kills.runs += 1
        kills.keep(file)
        with subprocess.Popen([sys.executable, '-c', CODE, *command]) as master:
            while _is_at_work(master, kills, out, len(kills.seen) + random.integers(*between)):
                time.sleep(float(random.uniform(0.0, _BLUR)))
                if random.random() < 0.3:
                    kills.masters += 1
                    say(f'{len(kills.seen)} done: the master is killed')
                    master.kill()
                    break
                victims = workers_of(master.pid)
                if victims:
                    kills.workers += 1
                    say(f'{len(kills.seen)} done: a worker is killed')
                    _kill(int(random.choice(victims)))
            else:
                kills.look(out)
                return kills


def _is_at_work(master: subprocess.Popen[Any], kills: Kills, out: Path, enough: int) -> bool:
    """Wait until so many are done; tell whether the master has more to do then."""
    while master.poll() is None:
        kills.look(out)
        if len(kills.seen) >= enough:
            kills.keep(out / KEPT)
            return True
        time.sleep(_TICK)
    return False


def _kill(process: int) -> None:
    try:
        os.kill(process, signal.SIGKILL)
    except ProcessLookupError:
        return


def workers_of(master: int) -> list[int]:
    """Return the processes of joblib that a master has started, on Linux."""
    found = []
    for path in Path('/proc').glob('[0-9]*'):
        try:
            parent = int((path / 'stat').read_text().rpartition(')')[2].split()[1])
            words = (path / 'cmdline').read_bytes()
        except (OSError, ValueError):
            continue
        if parent == master and b'popen_loky' in words:
            found.append(int(path.name))
    return found


def same_figures(one: Path, other: Path) -> bool:
    """Tell whether two results say the same to the last digit."""
    contents = [json.loads(path.read_text()) for path in (one, other)]
    for content in contents:
        for key in _OF_THE_RUN:
            content.pop(key)
    return bool(contents[0] == contents[1])


def one_by_one(jobs: list[list[str]], folder: Path) -> list[Path]:
    """Run commands one after the other, as a user would; return their results."""
    results = []
    for number, arguments in enumerate(jobs):
        out = folder / f'{number:03}'
        if not (out / 'report.html').is_file():
            command = [sys.executable, '-c', CODE, *arguments, '--out', str(out)]
            subprocess.run(command, check=False, capture_output=True)
        results.append(out / 'result.json')
    return results
