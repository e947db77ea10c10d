# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Entry point of `diffcal`."""

import argparse
from collections.abc import Sequence
import sys

from diffcal_ros import __version__
from diffcal_ros.cli import COMMANDS
from diffcal_ros.errors import InputError

EXIT_DONE = 0
EXIT_BAD_INPUT = 2
EXIT_NOT_FITTED = 3
_EXIT_INTERRUPTED = 130


def make_parser() -> argparse.ArgumentParser:
    """Build the parser with every subcommand."""
    parser = argparse.ArgumentParser(
        prog='diffcal',
        description="Find a soft body's simulator parameters from depth images.",
        epilog='Exit codes: 0 done, 2 bad input; of a calibration 0 converged, 3 no usable fit, '
        '4 the model disagrees with the data, 5 several answers explain them about as well.',
    )
    parser.add_argument('--version', action='version', version=f'diffcal {__version__}')
    subparsers = parser.add_subparsers(dest='command', metavar='COMMAND', required=True)
    for command in COMMANDS:
        command.add_parser(subparsers)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one subcommand; return the exit code."""
    parsed = make_parser().parse_args(arguments)
    try:
        return int(parsed.run(parsed))
    except InputError as error:
        print(f'diffcal {parsed.command}: {error}', file=sys.stderr)
        return EXIT_BAD_INPUT
    except KeyboardInterrupt:
        print(f'diffcal {parsed.command}: interrupted', file=sys.stderr)
        return _EXIT_INTERRUPTED
