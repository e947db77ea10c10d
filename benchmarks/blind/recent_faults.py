# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a set-up of the last sets: numbers that are 0 else."""

from dataclasses import dataclass


@dataclass(frozen=True)
class RecentFaults:
    """Amplitudes of the twenty-seventh set and those after it, and what older ones say there.

    `mass_form` may be `sliding`: a weight on a spring along the body, which is at `added_mass_at`
    where that is level. `contrast_mode` may be `dosed`: a sawtooth of `contrast_wave`, one of
    whose teeth begins at `contrast_at`. `stiffening_form` may be `foam strip`: on the lower side,
    by the exponential of the square of how it is pressed. `contact_form` may be `corrugated`: a
    hard sheet, which waves along one way aslant to the world's x.
    `depth_form` may be `two taps`: one error on the right of a column, another on its left.
    `tilt_form` may be `louvred`: a push through a grille of upright slats. `curvature_form` may be
    `hammock`: the arc of a catenary, whose lowest place was at `curvature_at`.

    In the twenty-eighth, `mass_form` may be `slinky`: a loose spring around the body, from
    `added_mass_at` on. `contrast_mode` may be `baked`: by how hot a mould was between two blocks,
    whose coolest place is at `contrast_at`. `clamp_form` may be `gooseneck`: on a round rod that
    is bent to a quarter of a circle. `contact_form` may be `tent`: a hard roof, whose ridge is
    rounded by `contact_round`. `depth_form` may be `shifted bar`: by the cubic of the way along a
    bar that is bent like an S. `tilt_form` may be `lee`: a push but for what is behind a post.
    `curvature_form` may be `mattress`: by the moment of a body on springs, at whose clamp a weight
    lay.

    In the twenty-ninth, `mass_form` may be `solder`: a wire around the body, closer and closer
    towards the tip. `contrast_mode` may be `surged`: a wave of `contrast_wave` from the clamp on,
    which falls over `contrast_width`. `stiffening_form` may be `corded`: cords along the upper and
    the lower side, which go no further than by `stiffening_from`. `clamp_form` may be `coil
    spring`: on one that stands below it. `contact_form` may be `gel pad`: by the cube of the dent
    over `contact_bend`. `tilt_form` may be `screened`: a push past an upright edge.
    `curvature_form` may be `four-point`: by the moment between two feet, at `curvature_at` and
    `curvature_again`, and two ends.

    In the thirtieth, `mass_form` may be `spray can`: paint of one that was held still at
    `added_mass_at`. `contrast_mode` may be `seeped`: oil from the clamp on, by `contrast_width`.
    `clamp_form` may be `hairpin`: on a rod that goes back and comes forward again. `contact_form`
    may be `rubber balls`: by the power 3/2 of the dent over `contact_bend`. `depth_form` may be
    `glued window`: by the way from a seam. `tilt_form` may be `hub`: a hollow round stream.
    `curvature_form` may be `slots`: by the moment between two that lie beside each other.

    In the thirty-first, `mass_form` may be `vine`: a wire that winds around from `added_mass_at`
    to the tip. `contrast_mode` may be `motor heat`: from the clamp on, farther in each pose.
    `clamp_form` may be `twisted strap`: on a flat one that comes round by a quarter of a turn.
    `contact_form` may be `saddle`: a hard one, by the squares of both ways over the radius
    `contact_round`, which rises along the way of `contact_slant`. `depth_form` may be `wiped`:
    what is farther from a spot than `depth_width`. `tilt_form` may be `eddy`: a push over an edge,
    and back below. `curvature_form` may be `over a rod`: by the moment of a rod at `curvature_at`
    below a body whose ends were held.

    In the thirty-second, `mass_form` may be `hourglass`: sand that runs between two bulbs, at
    `mass_stops`. `contrast_mode` may be `rolled sheets`: by steps from the clamp on.
    `stiffening_form` may be `rovings`: of glass along the edges, whose filaments come taut one
    after another. `clamp_form` may be `hexapod`: on six legs that give way along themselves.
    `depth_form` may be `breath`: what is nearer to a spot than one of `depth_places`. `tilt_form`
    may be `wall jet`: a push along an upright wall. `curvature_form` may be `woven`: by short
    bends one way and back in turn, at `curvature_wires`.

    In the thirty-third, `mass_form` may be `harness`: wires from the clamp on, one of which ends
    at each of `mass_gauges`. `contrast_mode` may be `heat gun`: a bell about `contrast_at`, which
    spreads and fades from pose to pose. `contact_form` may be `rim`: of a bucket, by the square of
    the way from its circle. `depth_form` may be `sealed window`: a plate that bulges between its
    edges. `tilt_form` may be `downwash`: a push away from `tilt_point` to all sides.
    `curvature_form` may be `wrapped`: by short bends one way, at `curvature_corners`.

    Attributes:
        mass_travel: by which share of the free length a weight slides on where the body points
            straight down, or what a loose spring is longer there.
        mass_closer: share of the free length over which turns come to be three times as many.
        mass_spray: distance of a nozzle, as a share of the free length.
        mass_wind: share of the free length over which a wire goes round once, from y towards z;
            below 0: the other way.
        mass_side: where it is at its beginning, from the object's y towards z [deg].
        mass_flow: which part of an hourglass's sand runs down in a pose.
        mass_gauges: shares of the free length at which a wire of a harness ends each.
        mass_coiled: length of a loose spring on a level body, as a share of the free length.
        contrast_sheets: number of sheets at the tip of which a body was rolled up.
        contrast_wider: by which share of that in the first pose the square of a heat's width grows
            from pose to pose.
        stiffening_spread: growth of their square over which a roving's filaments come taut, all
            but the first, which does at `stiffening_from`.
        contact_slant: of the way along which a corrugated sheet waves, or across a tent's ridge,
            from the world's x towards z; of the way along which a saddle rises [deg].
        contact_ring: radius of a bucket's rim [m].
        contact_steep: of a tent's sides, rise over run.
        depth_back: error of the left tap, the other way, as a share of `depth_bias`.
        region_net: way along the body from knot to knot of a net's meshes [m], and which share of
            that a thread covers; (0, 0): there is no net.
        region_bell: share of the free length where a region errs most, and over which it falls to
            a third of that; (0, 0): it is no bell.
        region_tongue: share of the free length from which on a region is all around, which grows
            on each side from a point at `region_from`; 0: it is so at once.
        region_edges: share of the way from an edge to the middle of a side where a region is, all
            along the edges; 0: it is on all of a side.
        region_flakes: edge of the flakes of a coat, fewer of which are left the nearer they lie
            to `region_from` [m]; 0: none came off.
        region_bars: shares of the free length at which the dark bars of a label begin and end in
            turn; empty: there is no label.
        tilt_wave: from slat to slat of a grille [m].
        curvature_sag: radius of a catenary at its lowest place, as a share of the free length.
        curvature_bed: share of the free length over which a moment on a mattress falls to a third.
        curvature_wires: shares of the free length at which a body was bent around wires.
        curvature_corners: shares of the free length at which a body was bent around a post.
        joggled: by how much the outer part of the true body lies beside the stated one [mm].
        joggled_at: share of the free length amid the bend where it goes over to that.
        joggled_way: direction of it, from the object's y towards z [deg].
        moire: amplitude of an error that is the product of two waves across the image [mm].
        moire_periods: of these [px].
        moire_slant: angle of the first's way, from the image's right towards down; the other goes
            at right angles to it [deg].
        moire_phases: of both at the principal point [rad].
        mitred: by how much one side of the true body's end is shorter [mm].
        mitred_side: 1 where that is the side of positive y, -1 where it is the other one, and 0
            where nothing is.
        lapsed: by how much what comes after lost bytes lies to the right [px].
        lapsed_row: of the image, from which on it does.
        clubbed: share by which the true section is larger at the tip.
        jittered: by how much each row of an image lies to a side at most [px].
        jittered_seed: of the draws of all rows.
        underfilled: share of the height that the true upper side lacks at the tip.
        spoked: amplitude of an error that waves about a place of the image [mm].
        spoked_at: that place, to the right of the principal point and down [px].
        spoked_count: of waves in a turn.
        spoked_phase: of these on the right of that place [rad].
        domed: by how much the edges of the true body's end lie behind its middle [mm].
        crosstalk: error where most of a column of the image sees something [mm].
        keeled: by how much a ridge stands out amid the true body's side of positive y [mm].
        spiralled: amplitude of an error that goes round a place of the image as a spiral [mm].
        spiralled_at: that place, to the right of the principal point and down [px].
        spiralled_apart: from turn to turn of it [px].
        bevelled: by how much the true body lacks at the upper edge of positive y [mm].
        sawtoothed: error at the end of a strip of columns, and as much the other way at its
            beginning [mm].
        sawtoothed_strip: width of a strip [px].
        sawtoothed_from: column at which one begins [px].
        chirped: amplitude of an error by the sine of the square of the way across the image [mm].
        chirped_at: column from which that goes, from the principal point [px].
        chirped_wave: way of its first wave [px].
    """

    mass_travel: float = 0.0
    mass_closer: float = 1.0
    mass_spray: float = 1.0
    mass_wind: float = 1.0
    mass_side: float = 0.0
    mass_flow: float = 0.0
    mass_gauges: tuple[float, ...] = ()
    mass_coiled: float = 0.0
    contrast_sheets: int = 0
    contrast_wider: float = 0.0
    stiffening_spread: float = 0.0
    contact_slant: float = 0.0
    contact_ring: float = 0.0
    contact_steep: float = 0.0
    depth_back: float = 0.0
    region_net: tuple[float, float] = (0.0, 0.0)
    region_bell: tuple[float, float] = (0.0, 0.0)
    region_tongue: float = 0.0
    region_edges: float = 0.0
    region_flakes: float = 0.0
    region_bars: tuple[float, ...] = ()
    tilt_wave: float = 1.0
    curvature_sag: float = 1.0
    curvature_bed: float = 1.0
    curvature_wires: tuple[float, ...] = ()
    curvature_corners: tuple[float, ...] = ()
    joggled: float = 0.0
    joggled_at: float = 0.0
    joggled_way: float = 0.0
    moire: float = 0.0
    moire_periods: tuple[float, float] = (1.0, 1.0)
    moire_slant: float = 0.0
    moire_phases: tuple[float, float] = (0.0, 0.0)
    mitred: float = 0.0
    mitred_side: float = 0.0
    lapsed: float = 0.0
    lapsed_row: int = 0
    clubbed: float = 0.0
    jittered: float = 0.0
    jittered_seed: int = 0
    underfilled: float = 0.0
    spoked: float = 0.0
    spoked_at: tuple[float, float] = (0.0, 0.0)
    spoked_count: int = 0
    spoked_phase: float = 0.0
    domed: float = 0.0
    crosstalk: float = 0.0
    keeled: float = 0.0
    spiralled: float = 0.0
    spiralled_at: tuple[float, float] = (0.0, 0.0)
    spiralled_apart: float = 1.0
    bevelled: float = 0.0
    sawtoothed: float = 0.0
    sawtoothed_strip: float = 1.0
    sawtoothed_from: float = 0.0
    chirped: float = 0.0
    chirped_at: float = 0.0
    chirped_wave: float = 1.0
