# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a command says while it works: on standard error, for output is for results."""

import sys


def say(text: str) -> None:
    """Say a line at once."""
    print(text, file=sys.stderr, flush=True)
