# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What no command foresaw: a sentence, and a log file that helps to find the fault."""

import argparse
from collections.abc import Iterator, Sequence
from datetime import datetime, timezone
import errno
from importlib import metadata
import os
from pathlib import Path
import platform
import sys
import tempfile
import traceback

from diffcal_ros import __version__
from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.errors import InputError

# What the loader of libraries and Warp say without memory.
_OF_MEMORY = ('failed to map segment from shared object', 'Failed to allocate')
_LIBRARIES = ('numpy', 'scipy', 'warp-lang', 'opencv-python-headless', 'matplotlib', 'PyYAML')


def report_fault(error: Exception, args: argparse.Namespace, given: Sequence[str]) -> None:
    """Say that something went wrong which should not, and where the log file is.

    Args:
        error: what was raised.
        args: the command's, parsed.
        given: the same as they were typed.
    """
    what = f'{type(error).__name__}: {error}'.strip(': ').splitlines()[0]
    log = _write_log(_log_text(error, given), args)
    if log is None:
        traceback.print_exception(error)
    if _is_of_memory(error):
        sentence = (
            f'there was not enough memory ({what}): use a coarser mesh, smaller or fewer images, '
            'or a machine with more'
        )
        asked = 'where is told above' if log is None else f'where stands in {log}'
    else:
        sentence = f'stopped by a fault in diffcal itself ({what})'
        where = ' with the lines above' if log is None else f', with the file {log}'
        asked = f'please report it{where}'
    print(f'diffcal {args.command}: {sentence}; {asked}', file=sys.stderr)


def _is_of_memory(error: BaseException | None) -> bool:
    """Tell whether there was too little memory, also where a library or Warp says so."""
    while error is not None:
        if isinstance(error, MemoryError) or getattr(error, 'errno', None) == errno.ENOMEM:
            return True
        if any(words in str(error) for words in _OF_MEMORY):
            return True
        error = error.__cause__ or error.__context__
    return False


def _write_log(text: str, args: argparse.Namespace) -> Path | None:
    """Write the log file where that is possible; return where."""
    name = f'diffcal-fault-{datetime.now():%Y%m%d-%H%M%S}-{os.getpid()}.log'
    for folder in _folders(args):
        try:
            write_text_atomically(folder / name, text)
        except (InputError, OSError):
            continue
        return folder / name
    return None


def _folders(args: argparse.Namespace) -> Iterator[Path]:
    out = getattr(args, 'out', None)
    if isinstance(out, Path) and out.is_dir():
        yield out
    yield Path()
    try:
        yield Path(tempfile.gettempdir())
    except FileNotFoundError:
        return


def _log_text(error: Exception, given: Sequence[str]) -> str:
    lines = [
        f'diffcal {__version__}, {datetime.now(timezone.utc).isoformat(timespec="seconds")}',
        f'arguments: {list(given)!r}',
        f'Python {platform.python_version()} on {platform.platform()}',
        *(f'{name} {_version(name)}' for name in _LIBRARIES),
        '',
        ''.join(traceback.format_exception(error)),
    ]
    return '\n'.join(lines)


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return 'is not installed under this name'
