# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an interruption leaves half made: objects whose end fails because they never began."""

import sys
from typing import Any


def leave_half_made_untold() -> None:
    """Say no more of what fails while objects are cleared away; an interruption goes before.

    It strikes anywhere, in a library's constructor too. The object is then dropped without the
    attributes that its `__del__` asks for, and Python would print that as if it were a fault.
    For the rest of the process, since such objects may hang in cycles until its end. A hook that
    someone else has put there stays.
    """
    if sys.unraisablehook is sys.__unraisablehook__:
        sys.unraisablehook = _say_nothing


def _say_nothing(unraisable: Any, /) -> None:
    del unraisable
