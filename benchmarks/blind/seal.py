# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fix the labels before a run: one SHA-256 a label, to be committed.

python -m benchmarks.blind.seal --labels DIR/labels --out benchmarks/blind/sealed_labels.sha256
sha256sum --check FILE        # in the folder of the labels
"""

import argparse
import hashlib
from pathlib import Path
import sys


def seal(labels: Path) -> str:
    """Return the list of hashes, in the format of sha256sum."""
    files = sorted(labels.glob('*.json'))
    if not files:
        raise FileNotFoundError(f'there are no labels in {labels}: run the generator first')
    return ''.join(f'{_digest(file)}  {file.name}\n' for file in files)


def broken(labels: Path, sealed: str) -> list[str]:
    """Return the names of labels that are missing or were changed since."""
    found = []
    for line in sealed.splitlines():
        digest, _, name = line.partition('  ')
        file = labels / name
        if not file.is_file() or _digest(file) != digest:
            found.append(name)
    return found


def seal_complaint(labels: Path, seal_file: Path | None) -> str:
    """Say which labels differ from their seal; empty where none does, or there is no seal."""
    changed = [] if seal_file is None else broken(labels, seal_file.read_text())
    return f'labels differ from their seal: {", ".join(changed[:5])}' if changed else ''


def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def main(arguments: list[str] | None = None) -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--labels', type=Path, required=True)
    parser.add_argument('--out', type=Path, required=True)
    given = parser.parse_args(arguments)
    if given.out.exists():
        print(f'{given.out} exists: a seal is set once', file=sys.stderr)
        return 2
    given.out.write_text(seal(given.labels))
    return 0


if __name__ == '__main__':
    sys.exit(main())
