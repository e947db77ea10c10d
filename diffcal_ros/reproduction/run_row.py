# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Do an experiment from all its starts; what is done already is left as it is."""

from collections.abc import Callable, Sequence
from pathlib import Path

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.offline.calibrate_recordings import OfflineInputs
from diffcal_ros.reproduction.experiment_data import open_members
from diffcal_ros.reproduction.row import Row, Variant
from diffcal_ros.reproduction.start_fit import fit_from_start, is_done

PICTURE = 'picture.png'
Draw = Callable[[Path, Calibration, CalibrationResult], None]


def start_files(row: Row, variant: Variant, out: Path, starts: int) -> list[Path]:
    """Return where each start's result goes."""
    folder = out / row.name / variant.name
    count = min(starts, variant.starts or starts)
    return [folder / f'start_{number:02}.json' for number in range(count)]


def run_row(
    row: Row,
    dataset: Path | None,
    out: Path,
    *,
    starts: int,
    draw: Draw,
    report: Callable[[str], None] = lambda _: None,
) -> None:
    """Fit every variant from every start that is not done.

    Args:
        row: the experiment.
        dataset: root of the public data set, or None.
        out: folder of all experiments.
        starts: of each variant that does not want fewer.
        draw: draws start and end of the first start's fit into a file.
        report: called with what is being done.

    Raises:
        InputError: when an experiment's data are missing or wrong.
    """
    for variant in row.variants:
        files = start_files(row, variant, out, starts)
        left = [n for n, path in enumerate(files) if not is_done(path, variant, row.name)]
        if not left:
            report(f'{row.name}, {variant.name}: done before')
            continue
        report(f'{row.name}, {variant.name}: opening')
        inputs = open_members(variant, dataset, files[0].parent)
        for number in left:
            _fit(row, variant, inputs, number, files[number], draw)
            report(f'{row.name}, {variant.name}: start {number + 1} of {len(files)}')


def _fit(
    row: Row,
    variant: Variant,
    inputs: Sequence[OfflineInputs],
    number: int,
    path: Path,
    draw: Draw,
) -> None:
    picture = path.parent / PICTURE

    def on_fitted(calibration: Calibration, result: CalibrationResult) -> None:
        if number == 0 or not picture.exists():
            draw(picture, calibration, result)

    fit_from_start(inputs, variant, number, path, seed=row.name, on_fitted=on_fitted)
