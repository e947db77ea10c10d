# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Run a subcommand of `diffcal`, and say in a sentence whatever goes wrong."""

import argparse
from collections.abc import Sequence
import errno
import os
import sys

from diffcal_ros import __version__
from diffcal_ros.cli.command_list import COMMANDS
from diffcal_ros.cli.interruption import Abandoned, run_interruptibly
from diffcal_ros.cli.last_resort import report_fault
from diffcal_ros.cli.lasting_stream import lasting_streams, LastingStream
from diffcal_ros.cli.solve_progress import solve_progress
from diffcal_ros.errors import InputError
from diffcal_ros.user_folders import settle_home

EXIT_DONE = 0
EXIT_BAD_INPUT = 2
EXIT_NOT_FITTED = 3
EXIT_FAULT = 70
EXIT_NOT_SAID = 74
EXIT_INTERRUPTED = 130

# What files and folders may be the cause of, whatever a command does with them.
_OF_THE_MACHINE = (
    *(errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOENT, errno.ENOTDIR, errno.EISDIR),
    *(errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.ELOOP, errno.ENAMETOOLONG),
)


def make_parser() -> argparse.ArgumentParser:
    """Build the parser with every subcommand."""
    parser = argparse.ArgumentParser(
        prog='diffcal',
        description="Find a soft body's simulator parameters from depth images.",
        epilog='Exit codes: 0 done, 2 bad input; of a calibration 0 converged, 3 no usable fit, '
        '4 the model disagrees with the data, 5 several answers explain them about as well. '
        '70: a fault in diffcal itself, or too little memory, told in a log file; 74: all files '
        'are written, but standard output is full; 130: interrupted (a second Ctrl-C ends at '
        'once). A reader that closes the pipe, such as `head`, changes neither files nor code.',
    )
    parser.add_argument('--version', action='version', version=f'diffcal {__version__}')
    subparsers = parser.add_subparsers(dest='command', metavar='COMMAND', required=True)
    for command in COMMANDS:
        command.add_parser(subparsers)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one subcommand; return the exit code."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    with lasting_streams() as output:
        parsed = make_parser().parse_args(given)
        try:
            settle_home()
            # Pictures go to files: what is stated for windows need not be there.
            os.environ.pop('MPLBACKEND', None)
            with solve_progress():
                code = run_interruptibly(lambda: int(parsed.run(parsed)))
        except InputError as error:
            print(f'diffcal {parsed.command}: {error}', file=sys.stderr)
            code = EXIT_BAD_INPUT
        except KeyboardInterrupt as interrupt:
            _report_interruption(parsed)
            code = EXIT_INTERRUPTED
            if isinstance(interrupt, Abandoned):
                _end_now(code)
        except Exception as error:
            code = _report_unforeseen(error, parsed, given)
        return _code_once_said(output, code, parsed.command)


def _report_unforeseen(error: Exception, parsed: argparse.Namespace, given: Sequence[str]) -> int:
    """Tell what the machine refused, or a fault of this program; return the exit code."""
    if isinstance(error, OSError) and error.errno in _OF_THE_MACHINE:
        where = f'{error.filename}: ' if error.filename else ''
        print(
            f'diffcal {parsed.command}: {where}{error.strerror}: see that files and folders are '
            'there and may be used, and that the disk has room',
            file=sys.stderr,
        )
        return EXIT_BAD_INPUT
    report_fault(error, parsed, given)
    return EXIT_FAULT


def _report_interruption(parsed: argparse.Namespace) -> None:
    """Say what is left, where the command knows."""
    what_is_left = getattr(parsed, 'what_is_left', lambda: 'interrupted')
    print(f'diffcal {parsed.command}: {what_is_left()}', file=sys.stderr)


def _end_now(code: int) -> None:
    """End the process under native code that did not return in time."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _code_once_said(output: LastingStream, code: int, command: str) -> int:
    """Return the exit code: whoever closes the pipe has read enough, a full disk is told."""
    output.flush()
    if output.fault is None or output.fault.errno == errno.EPIPE:
        return code
    print(
        f'diffcal {command}: standard output cannot be written ({output.fault.strerror}): '
        'send it elsewhere. All files are written',
        file=sys.stderr,
    )
    return code or EXIT_NOT_SAID
