# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal view`: a fit in the browser."""

import argparse
from pathlib import Path
from typing import Any, TYPE_CHECKING

from diffcal_ros.cli.options.page_options import add_page_options, asked_page, say_where
from diffcal_ros.cli.options.path_argument import path_argument
from diffcal_ros.cli.options.recording_options import add_input_options
from diffcal_ros.cli.say import say

if TYPE_CHECKING:
    from diffcal_ros.web.fitted_view import SeenBody


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'view',
        help='look at a fit in the browser',
        description='Serve a page with the fitted body over the points that the camera measured, '
        'what is held, the camera, and the figures of the fit. Only this machine reaches it '
        'unless --host says otherwise.',
    )
    parser.add_argument(
        'fit', metavar='FIT', type=path_argument, help='folder of `diffcal calibrate --out`'
    )
    parser.add_argument(
        'bags',
        metavar='BAG',
        nargs='*',
        type=path_argument,
        help='the recordings of the fit, where they are elsewhere now',
    )
    add_page_options(parser.add_argument_group('the page'))
    parser.add_argument(
        '--rrd',
        metavar='FILE',
        type=path_argument,
        help="write a recording for Rerun's viewer, in place of the page",
    )
    add_input_options(parser.add_argument_group('what is read'))
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C, or write the file; return the exit code."""
    if args.rrd is not None:
        return _write(args, args.rrd)
    with asked_page(args) as server:
        from diffcal_ros.web.server import wait_for_interrupt
        from diffcal_ros.web.view_page import ViewPage

        ViewPage(server, *_seen(args))
        say_where(server)
        wait_for_interrupt()
    return 0


def _write(args: argparse.Namespace, path: Path) -> int:
    from diffcal_ros.web.rerun_file import require_rerun, write_rerun

    require_rerun()
    write_rerun(path, *_seen(args))
    print(f'written {path}')
    return 0


def _seen(args: argparse.Namespace) -> 'tuple[list[SeenBody], str]':
    """Read and simulate the fit; return what is drawn, and its figures."""
    from diffcal_ros.web.fit_folder import read_fit
    from diffcal_ros.web.fit_words import fit_words
    from diffcal_ros.web.fitted_view import seen_fit

    fit = read_fit(args.fit)
    say('reading the recordings')
    inputs = fit.open(
        args.bags,
        pose_source=args.pose,
        depth_topic=args.depth_topic,
        allow_truncated=args.allow_truncated,
    )
    say('simulating the fitted body')
    return seen_fit(fit, inputs), fit_words(fit.scene.name, fit.document)
