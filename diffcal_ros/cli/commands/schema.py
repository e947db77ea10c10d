# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal schema`: print the JSON schema of scene files, for editors."""

import argparse
from typing import Any


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'schema',
        help='print the JSON schema of scene files',
        description='Print the JSON schema of scene files. An editor with a YAML language server '
        'then completes and checks a scene that starts with the line '
        '`# yaml-language-server: $schema=scene.schema.json`.',
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print the schema; return the exit code."""
    from diffcal_ros.scene.schema import scene_schema_text

    print(scene_schema_text(), end='')
    return 0
