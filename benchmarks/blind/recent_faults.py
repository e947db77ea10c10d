# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a set-up of the twenty-seventh set: numbers that are 0 else."""

from dataclasses import dataclass


@dataclass(frozen=True)
class RecentFaults:
    """Amplitudes that came with the twenty-seventh set, and what older ones say there.

    `mass_form` may be `sliding`: a weight on a spring along the body, which is at `added_mass_at`
    where that is level. `contrast_mode` may be `dosed`: a sawtooth of `contrast_wave`, one of
    whose teeth begins at `contrast_at`. `stiffening_form` may be `foam strip`: on the lower side,
    by the exponential of the square of how it is pressed. `contact_form` may be `corrugated`: a
    hard sheet, which waves along one way aslant to the world's x.
    `depth_form` may be `two taps`: one error on the right of a column, another on its left.
    `tilt_form` may be `louvred`: a push through a grille of upright slats. `curvature_form` may be
    `hammock`: the arc of a catenary, whose lowest place was at `curvature_at`.

    Attributes:
        mass_travel: by which share of the free length a weight slides on where the body points
            straight down.
        contact_slant: of the way along which a corrugated sheet waves, from the world's x towards
            z [deg].
        depth_back: error of the left tap, the other way, as a share of `depth_bias`.
        region_net: way along the body from knot to knot of a net's meshes [m], and which share of
            that a thread covers; (0, 0): there is no net.
        tilt_wave: from slat to slat of a grille [m].
        curvature_sag: radius of a catenary at its lowest place, as a share of the free length.
        joggled: by how much the outer part of the true body lies beside the stated one [mm].
        joggled_at: share of the free length amid the bend where it goes over to that.
        joggled_way: direction of it, from the object's y towards z [deg].
        moire: amplitude of an error that is the product of two waves across the image [mm].
        moire_periods: of these [px].
        moire_slant: angle of the first's way, from the image's right towards down; the other goes
            at right angles to it [deg].
        moire_phases: of both at the principal point [rad].
    """

    mass_travel: float = 0.0
    contact_slant: float = 0.0
    depth_back: float = 0.0
    region_net: tuple[float, float] = (0.0, 0.0)
    tilt_wave: float = 1.0
    curvature_sag: float = 1.0
    joggled: float = 0.0
    joggled_at: float = 0.0
    joggled_way: float = 0.0
    moire: float = 0.0
    moire_periods: tuple[float, float] = (1.0, 1.0)
    moire_slant: float = 0.0
    moire_phases: tuple[float, float] = (0.0, 0.0)
