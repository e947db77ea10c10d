# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Names that people chose, in figures."""


def as_text(words: str) -> str:
    """Return words that matplotlib draws as they are: no formula between two dollars."""
    printable = words.encode('utf-8', errors='backslashreplace').decode('utf-8')
    return printable.replace('$', r'\$')
