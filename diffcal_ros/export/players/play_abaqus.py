# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Run body.inp with CalculiX and print how far the body sinks: `python play_abaqus.py`.

Needs `ccx` on the PATH (CalculiX, as Debian's and Ubuntu's package calculix-ccx has it). Abaqus
runs the same file: `abaqus job=body`.
"""

from pathlib import Path
import shutil
import subprocess


def run(folder: Path) -> float:
    """Solve the step; return the largest displacement [m]."""
    program = shutil.which('ccx')
    if program is None:
        raise SystemExit('there is no `ccx` on the PATH: install CalculiX (calculix-ccx)')
    subprocess.run([program, 'body'], cwd=folder, check=True)
    return largest_displacement((folder / 'body.dat').read_text())


def largest_displacement(text: str) -> float:
    """Return the largest displacement of the last step that a .dat file holds [m]."""
    largest = 0.0
    for line in text.splitlines():
        words = line.split()
        if 'displacements' in line:
            largest = 0.0
        elif len(words) == 4 and words[0].isdigit():
            x, y, z = (float(word) for word in words[1:])
            largest = max(largest, (x * x + y * y + z * z) ** 0.5)
    return largest


def main() -> None:
    """Play the asset beside this script."""
    print(f'moved by up to {1e3 * run(Path(__file__).parent):.3f} mm')


if __name__ == '__main__':
    main()
