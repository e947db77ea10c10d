# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Text from a file, made fit to be printed."""

from collections.abc import Sequence


def plain(text: str, longest: int = 60) -> str:
    """Shorten a text, and write characters that cannot be printed as escapes.

    Args:
        text: of any content.
        longest: so many characters stay.
    """
    shown = text if len(text) <= longest else f'{text[: longest - 1]}…'
    return ''.join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in shown)


def listed(items: Sequence[str], most: int = 12) -> str:
    """Join some items by commas, and count those that are too many."""
    more = f' and {len(items) - most} more' if len(items) > most else ''
    return ', '.join(items[:most]) + more
