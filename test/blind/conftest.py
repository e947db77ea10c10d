# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The benchmarks are no installed package: tests find them beside the sources."""

from collections.abc import Callable
from pathlib import Path
import sys

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from benchmarks.blind.faults import Faults  # noqa: E402
from benchmarks.blind.observe import true_rendering  # noqa: E402
from benchmarks.blind.setups import draw_setup, Setup  # noqa: E402
from benchmarks.blind.simulation import make_specimen, settle, Specimen  # noqa: E402

COARSE = 0.5
# Sets that are sealed and have been run: what they draw must stay as it is, which the slow suite
# checks, and so it does what is drawn or simulated of every form of every set.
_CLOSED = (
    *('sixth', 'seventh', 'eighth', 'ninth', 'tenth', 'eleventh', 'twelfth', 'thirteenth'),
    *('fourteenth', 'fifteenth', 'sixteenth', 'seventeenth', 'eighteenth', 'nineteenth'),
    *('twentieth', 'twentyfirst', 'twentysecond', 'twentythird', 'twentyfourth', 'twentyfifth'),
    *('twentysixth', 'twentyseventh', 'twentyeighth', 'twentyninth', 'thirtieth', 'thirtyfirst'),
    *('thirtysecond', 'thirtythird', 'thirtyfourth', 'thirtyfifth', 'thirtysixth'),
    *('thirtyseventh', 'swing_set'),
    *(
        'swings_two',
        'swings_three',
        'swings_four',
        'swings_five',
        'new_forms',
        'tip_moves',
        'later_sets',
    ),
)


def _is_closed(path: Path) -> bool:
    name = path.stem.removeprefix('test_')
    return path.parent == Path(__file__).parent and name.startswith(_CLOSED)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Read none of them where none is run: a quarter of all tests' lines."""
    is_fast = 'not slow' in config.getoption('markexpr')
    return True if is_fast and _is_closed(collection_path) else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave tests of closed sets to the slow suite."""
    for item in items:
        if _is_closed(item.path):
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope='module')
def setup() -> Setup:
    return draw_setup('beam', is_sealed=False, poses=4, random=np.random.default_rng(4))


@pytest.fixture(scope='module')
def plain(setup: Setup) -> Specimen:
    """That beam without a fault, in coarse cells."""
    return make_specimen(setup, Faults(), COARSE)


@pytest.fixture(scope='module')
def rests(setup: Setup, plain: Specimen) -> list[np.ndarray]:
    """Where it rests in each pose [m]."""
    return [settle(plain, setup, one, Faults()) for one in setup.observations]


@pytest.fixture(scope='module')
def depths(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> Callable[[Faults, int], np.ndarray]:
    """What a camera reads of it at all samples [m], infinite where nothing is."""

    def seen(faults: Faults, pose: int) -> np.ndarray:
        return true_rendering(plain, setup, setup.observations[pose], faults, rests[pose]).depth

    return seen
