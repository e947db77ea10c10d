# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Names for what is being written, which tell later whether its writer is still there."""

from contextlib import suppress
import glob
import os
from pathlib import Path
import platform
import re
import shutil
from uuid import uuid4

# The rest of a name of 255 bytes is for the machine, the process and the suffix.
_LONGEST_STEM, _LONGEST_HOST = 40, 40
# States of a process that has ended, Linux's proc(5).
_ENDED = 'ZX'
_WRITER = re.compile(r'-(\d+)-[0-9a-f]{8}')


def fresh_path(path: Path) -> Path:
    """Return a hidden path beside `path` that no other process writes to.

    The suffix stays last: image writers choose their format by it.
    """
    return path.with_name(f'{_start(path)}{os.getpid()}-{uuid4().hex[:8]}{path.suffix}')


def remove_leftovers(path: Path) -> None:
    """Remove what processes of this machine left beside `path` when they were killed."""
    for found in path.parent.glob(f'{glob.escape(_start(path))}*'):
        writer = _WRITER.search(found.name[len(_start(path)) - 1 :])
        if writer is None or _is_running(int(writer[1])):
            continue
        with suppress(OSError):
            if found.is_dir():
                shutil.rmtree(found)
            else:
                found.unlink()


def _start(path: Path) -> str:
    """Return how the names begin; folders may be shared by machines that count processes alike."""
    host = re.sub(r'[^A-Za-z0-9]', '', platform.node())[:_LONGEST_HOST]
    return f'.{path.stem[:_LONGEST_STEM]}.{host}-'


def _is_running(process: int) -> bool:
    """Tell whether a process runs; one that has ended may wait for long until its parent looks."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    try:
        state = Path(f'/proc/{process}/stat').read_text().rpartition(')')[2].split()[0]
    except (OSError, IndexError):  # It has gone since, or this is no Linux: see the next time.
        return True
    return state not in _ENDED
