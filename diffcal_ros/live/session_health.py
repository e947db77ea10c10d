# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a live calibration goes, in one sentence and a few figures."""

from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.live.fit_words import fit_level, outcome_words
from diffcal_ros.live.health import Health, Level
from diffcal_ros.live.node_words import told_of
from diffcal_ros.live.session import Phase, Session
from diffcal_ros.live.tracking import in_words, Tracking
import numpy as np

# Depth does not change by so much from one image to the next, unless it is in another unit.
_OTHER_UNIT = 100.0


def session_health(session: Session) -> Health:
    """Describe a session for /diagnostics."""
    level, message = _status(session)
    values = {
        'state': session.phase.value,
        'fits': str(session.fit_count),
        'captured observations': str(len(session.captured)),
        'device': session.settings.fit.device,
        'parameters at bounds': _at_bounds(session),
        'camera pose': session.inputs.source,
        'notes': _notes(session),
        'warnings': _warnings(session),
    }
    if session.last_step is not None:
        record = session.last_step.record
        values['iterations'] = str(record.number)
        values['step time [s]'] = f'{session.step_seconds:.4f}'
        values['gap median [mm]'] = f'{1e3 * record.gap.median:.4f}'
        values['gap RMS [mm]'] = f'{1e3 * record.gap.rms:.4f}'
        values['coverage [share]'] = f'{record.gap.coverage:.4f}'
        values['explained [share]'] = f'{record.gap.explained:.4f}'
    if session.swings is not None:
        values.update(session.swings.figures())
    if session.tracking is not None:
        values.update(session.tracking.figures())
        values.update(_tracked(session.tracking))
    return Health(level, message, values)


def _status(session: Session) -> tuple[Level, str]:
    if session.problem is not None:
        return Level.ERROR, session.problem
    for topic, reason in session.bad_inputs.items():
        return Level.ERROR, told_of(topic, reason)
    phase = session.phase
    if phase is Phase.PAUSED:
        return Level.WARN, 'paused: call ~/enable to go on'
    if session.failure is not None:
        return _failed(session, session.failure)
    if phase is Phase.FITTING:
        number = session.last_step.record.number if session.last_step else 0
        return Level.OK, f'fitting, iteration {number}'
    if session.tracking is not None:
        return _followed(session, session.tracking)
    if phase is Phase.DONE and session.last_end is not None:
        return _ended(session.last_end.result.outcome)
    missing = session.inputs.missing(session.window.newest)
    if missing:
        return Level.WARN, f'waiting for {", ".join(missing)}'
    if phase is Phase.PREPARING:
        return Level.OK, 'getting the kernels ready, compiled where they are not yet'
    if session.swings is not None:
        return session.swings.status()
    return Level.OK, f'collecting frames, {session.window.fresh_count} of {session.window.size}'


def _ended(outcome: Outcome) -> tuple[Level, str]:
    return fit_level(outcome), outcome_words(outcome)


def _failed(session: Session, outcome: Outcome) -> tuple[Level, str]:
    """Say the same until a fit succeeds, so that it is logged once."""
    level, words = fit_level(outcome), f'the last fit {outcome_words(outcome)}'
    if session.phase is Phase.DONE:
        return level, words
    return level, f'{words} New frames are fitted again every {session.retry_seconds:.0f} s.'


def _followed(session: Session, tracking: Tracking) -> tuple[Level, str]:
    """Say how tracking goes, and what was wrong with the fit that it started from."""
    level, words = _tracking(tracking)
    unusable = None if tracking.problem is None else _unusable(session)
    if unusable is not None:
        return Level.ERROR, unusable
    end = session.last_end
    if end is None or end.result.outcome.is_usable:
        return level, words
    outcome = end.result.outcome
    return max(level, fit_level(outcome)), f'{words}; the fit was {outcome_words(outcome)}'


def _unusable(session: Session) -> str | None:
    """Say why the newest image cannot show the body, wherever that is; None where it may."""
    newest, end = session.window.newest, session.last_end
    if newest is None or end is None:
        return None
    if newest.valid_fraction == 0.0:
        return (
            'no pixel of the depth images holds a depth: look after the range and the laser of '
            'the camera'
        )
    fitted = end.request.snapshots[-1].newest
    ratio = float(np.nanmedian(newest.depth) / np.nanmedian(fitted.depth))
    if 1.0 / _OTHER_UNIT < ratio < _OTHER_UNIT:
        return None
    return (
        f'depth is {ratio:.3g} times that of the fit: the images are in another unit now; 32FC1 '
        'is in metres, 16UC1 in millimetres (REP 118)'
    )


def _tracking(tracking: Tracking) -> tuple[Level, str]:
    if tracking.problem is not None:
        return Level.WARN, tracking.problem
    if tracking.last is None:
        return Level.OK, 'tracking, waiting for the first frame'
    if tracking.change is not None:
        return Level.OK, f'tracking, the body changed {in_words(tracking.change)}'
    return Level.OK, 'tracking'


def _tracked(tracking: Tracking) -> dict[str, str]:
    """Return figures of the last frame, which go before those of the last fit."""
    if tracking.last is None:
        return {}
    gap = tracking.last.tracked.gap
    return {
        'gap median [mm]': f'{1e3 * gap.median:.4f}',
        'gap RMS [mm]': f'{1e3 * gap.rms:.4f}',
        'coverage [share]': f'{gap.coverage:.4f}',
        'explained [share]': f'{gap.explained:.4f}',
    }


def _notes(session: Session) -> str:
    end = session.last_end
    notes = [] if end is None else end.result.details.get('notes', [])
    return '; '.join(str(note) for note in notes) or 'none'


def _warnings(session: Session) -> str:
    end = session.last_end
    return 'none' if end is None else '; '.join(end.result.warnings) or 'none'


def _at_bounds(session: Session) -> str:
    if session.tracking is not None and session.tracking.last is not None:
        parameters = session.tracking.last.tracked.parameters
    elif session.last_step is not None:
        parameters = session.last_step.parameters
    else:
        return 'none'
    return ', '.join(p.name for p in parameters if p.at_bound) or 'none'
