# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Paths on the command line; shells leave `--out=~/fit` as it is."""

import argparse
from pathlib import Path

from diffcal_ros.errors import InputError
from diffcal_ros.user_path import user_path


def path_argument(text: str) -> Path:
    """Read one, for `argparse`."""
    try:
        return user_path(text)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
