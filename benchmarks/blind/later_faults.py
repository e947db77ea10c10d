# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a set-up of the twelfth set or a later one: numbers that are 0 else."""

from dataclasses import dataclass

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class LaterFaults:
    """Amplitudes that came with the twelfth to the twenty-sixth set.

    Attributes:
        stiffening_slant: angle between the threads of a braid and the object's x [deg].
        stiffening_steep: factor of that square [-].
        contrast_until: share of the free length where a patch or a foil ends, or a wedge.
        contrast_side: sign of the object's y on whose side it is, or where a wedge is thickest, or
            of a ribbon that winds from the object's y towards z.
        mass_shares: how much of `added_mass` a cloth still has in each pose, or a cup has by then.
        clamp_preload: moment up to which a preloaded clamp does not give way [N m].
        contact_give: by how much a pan sinks by the force on it [m/N], or a flap turns by the
            moment on it [rad/(N m)].
        depth_entry: depth whose entry in a sensor's table is wrong [m].
        depth_spacing: between the entries of that table [m].
        guy: stiffness of lines from a post of the rig to one place of the body, which are as
            long as they are without a load, and slack where that is longer [N/m].
        guy_at: that place's share of the free length.
        guy_post: the post's end, object frame [mm].
        drawn: by which share the true body is longer beyond the clamp, at the same volume.
        curvature_shares: how much of `rest_curvature` is left in each pose; empty: all of it.
        region_places: share of the free length from which on `region_bias` is added in each pose;
            empty: `region_from` in all.
        mass_filled: share of a channel that its liquid fills.
        contrast_wave: length of the streaks' waves, of swirls', or of a ribbon's turns, as a share
            of the free length.
        contact_ahead: where a dish is lowest, or a cushion or a crate's foam highest, along the
            world's x [m], and along z at `contact_at`; or a knob highest, along the object's x,
            and along y at that; or where a flap's hinge is along the world's x.
        contact_round: radius to which a dish is round at its bottom; below 0: to which a cushion
            is at its top; or that of a pipe [m].
        clamp_rub: moment by which a clamp that rubs lags behind [N m].
        pane: thickness of a pane of acrylic before the camera, which nobody counts with [mm].
        pane_normal: its normal away from the camera, camera frame.
        crazed: by which share of E the uppermost quarter resists a pull along the object's x less
            than a push.
        skewed: by how much the columns of an image are shifted over its rows [-].
        clamp_pinch: share of its height that the held section loses between jaws.
        clamp_wedge: by how much that is more at the side of positive y.
        clamp_crept: share of its way that a clamp which creeps goes in each pose.
        contact_span: half the distance between a rope's posts [m].
        contact_drawn: by which share the rope is longer between them than if it were loose.
        contact_tension: force that draws it then [N].
        depth_veil: depth of what spreads its light over an image [m].
        region_bands: distance from band to band of tape, as a share of the free length, and
            which share of that a band has; from `region_from` on; (0, 0): all is one band.
        worn: share of E that rubber loses at most by strains of the poses before.
        clipped: how far the least depth that a sensor tells lies beyond `clipped_near` [mm].
        clipped_near: depth of the nearest place on a body's middle line [m].
        clamp_growth: factor by which what a clamp slips grows from pose to pose; 0: it does not.
        depth_roll: by how much more of an error of depth there is at the image's lower edge than
            in its middle, as a share of what is there.
        imager_tilt: of an imager behind its lens, about its x and y [rad].
        tilt_point: of the world, on the axis of a draught or a hair dryer, amid a curtain, or in
            the mouth of an extractor [m].
        tilt_width: distance from that axis at which a draught has fallen to a third, or a
            curtain to a sixth [m].
        magnetized: density of the energy of a body that is magnetized along its x, where it
            points against a steady field [J/m^3].
        magnetic_way: direction of that field in the world.
        necked: share by which the true section is smaller in the middle of a neck.
        necked_at: share of the free length of that middle.
        clamp_slant: of an angle iron's weak axis, from the object's y towards z [deg].
        contact_pressure: of bristles that are bent over, or by which that of felt is stated, or
            that of a table that blows, at `contact_height`, or the most of packing foam [Pa].
        contact_bend: dent at which two thirds of them are, or of packing foam's pressure, or over
            which the pressure of felt grows, or of air falls upwards, by a factor of e [m].
        curvature_again: share of the free length of the middle of an outer fold or bend.
        curvature_back: by which share of what the inner one turns that turns back, or at right
            angles to it.
        contrast_pours: share of `contrast` that each of some pours has, from the clamp on.
        tilt_above: how far a bench lies below where the camera looks, which slows air down [m].
        depth_spot: of the middle of a smudge in the image, or of a place amid a sunbeam in the
            first pose, or where a bent guard is met squarely, from its principal point [px].
        depth_width: way from there, or across the beam, or from a fixture that flares, at
            which its error has fallen to a third, or along a saddle's slant from the principal
            point, at which there is all of it, as from where a bent guard is met squarely, or over
            which a film's edge is blurred [px].
        region_wound: whether bands of tape are the turns of one that is wound around the body.
        ghost: share of the pose before in what a sensor tells where it saw something then.
        whirl: push of air that turns about an upright axis, where that is strongest [m/s^2].
        whirl_at: where that axis is along the world's x and z [m].
        whirl_radius: distance from it where the push is strongest [m].
        mass_count: number of markers.
        clamp_bow: turn per length of a held section in bowed jaws, about the object's y and z,
            from its inner end on [1/m].
        contact_stiffness: pressure of a cushion or a crate's foam by its dent [Pa/m]; 0: it is as
            hard as all else.
        depth_full: light from which on pixels are saturated, or are told by another gain, over
            that of what is met squarely where the camera looks [-].
        region_dot: edge of dots in which `region_bias` is added [m]; 0: there are none.
        region_cover: share of the surface that these dots cover.
        region_seed: of what is drawn for their places.
        dished: share of the height that the true body lacks amid its hollow upper side.
        fattened: by how much a body's outline is seen too far out [px].
        mass_ahead: from the middle of its foot on a body to a tool's mass, along the body [mm].
        clamp_gape: by how much less than stated a body is held by jaws that gape, or by glue [mm].
        contact_wave: way from crest to crest of a crate's foam, along the world's x and z, or from
            bar to bar of a rack, along x [m].
        contact_trough: by how much its troughs are lower than its crests [m].
        depth_point: of the world, from which light bounces to a body [m].
        region_strip: share of each side that a strip along its middle covers; 0: all of it.
        tilt_shares: how much of a fan's push there is in each pose, or which way a table rocks, or
            how much of its tilt a trolley has.
        shrinking: by how much all lengths of a body without stress are shorter at last [%].
        shrinking_shares: how much of that is there in each pose.
        bleeding: error of depth on a body's outline [mm].
        bleeding_width: way inwards from there over which it falls to a third [px].
        mass_anchor: where a slung cable hangs from the rig, object frame [mm].
        mass_longer: by which share that is longer than the way to where it ends on a body.
        contrast_seed: of what is drawn for the swirls of a rubber that was stirred too little.
        curvature_waves: number of waves over the free length.
        region_decay: share of the free length over which `region_bias` falls to a third, from
            the tip on; 0: it does not.
        center_scatter: further shift of the principal point in each pose [px].
        unglued: share of the free length, up to the tip, on which a body's upper and lower half
            hardly hold together.
        trailing: error of depth where a beam comes to a body [mm].
        trailing_width: way down the columns over which it falls to a third [px].
        mass_suction: height over which the water of a sponge falls to a third [m].
        tilt_scatter: further tilt about the world's x and z in each pose [deg].
        depth_slant: angle of the way in which a sunbeam wanders, or in which a saddle errs by all
            of it, or in which a film peels off, or across which a guard is bent, from the image's
            right towards down [deg].
        depth_wander: by how much it wanders that way from pose to pose [px].
        region_sun: direction, object's y and z, from which sun bleached a body: `region_bias`
            goes with the cosine of the angle between that and a side; (0, 0): it is on all.
        updraught: push of a stream of air upwards, on its axis [m/s^2].
        updraught_at: where that axis is along the world's x and z [m].
        updraught_width: distance from it at which the push has fallen to a third [m].
        stuck: what the bit of a depth counts for that is stuck, at 1 where that is positive, and
            else at 0 [mm].
        mass_places: share of the free length at which a lump of grease is in each pose, or up
            to which a cord is wet.
        contrast_depth: below the surface over which what was soaked falls to a third [m].
        clamp_shares: how much of `clamp_compliance` there is in each pose; empty: all of it.
        region_second: share of the free length from which on, up to `region_from`, a second
            paint is on a body; 0: there is none.
        region_back: error of that, the other way, as a share of `region_bias`.
        tilt_pushes: what draws every part beside gravity in each pose, world frame [m/s^2].
        curvature_parts: of parts that are alike in length, from the clamp on: which share of
            `rest_curvature` each has, and which share at right angles to that.
        flattened: share by which the true body is wider at the tip than the stated one; it is as
            much thinner there.
        combed: by how much the odd rows of an image are shifted to the right [px].
        contrast_creases: shares of the free length at which a body was creased.
        contrast_width: share of the free length over which a crease's contrast falls to a third.
        region_shares: how much of `region_bias` is there in each pose; empty: all of it.
        curvature_prop: share of the moment at the clamp that a block below the tip took away.
        reeled: steady pull of a reel's cord on the tip [N].
        droplet: by how much a drop on the window shifts what is behind it away from its middle,
            at most [px].
        droplet_at: where that middle is, from the image's principal point [px].
        droplet_width: how far from there it shifts most [px].
        mass_from: number of the first pose, from 0, in which what is hung on is there.
        depth_shares: how much of `depth_bias` a sensor that is restarted has in each pose.
        region_strokes: how much of `region_bias` each stroke of a brush has; empty: it is one.
        unlevel: share of the height by which the upper side of the true body is higher at the side
            of positive y, and lower at the other.
        flicker: amplitude of an error that swings over the image's rows [mm].
        flicker_period: [px].
        flicker_phases: at row 0 in each pose [rad].
        mass_drips: of some drips of glue: the share of the free length, the way across the body,
            from the object's y towards z [deg], and the share of `added_mass`.
        tilt_back: by which share of the outer fan's push the inner one blows the other way.
        curvature_heavy: share of the moment at a body's tip, by which it was held, that was its
            holder's.
        depth_places: how far from the image's principal point the edge of a film lies along
            `depth_slant` in each pose [px].
        region_dips: shares of the free length from which on each of some coats is on a body, all
            of which err alike; empty: it was not dipped.
        drafted: share by which the true section is wider at its upper side, and narrower at its
            lower one.
        blocky: edge of the squares of an image that all have the mean of their depths [px].
        contact_drops: by how much a jack has sunk in each pose [mm]; empty: it does not.
        depth_blend: light over which one gain goes over to the other [-].
        region_board: edge of the squares of a board, on every other of which `region_bias` is [m].
        ribbed: share by which the true section is larger and smaller in waves.
        ribbed_waves: number of them on the free length.
        ribbed_phase: at the clamp [rad].
        mirrored: share of the depth on the other side of a place in what a sensor tells.
        mirrored_at: where that place is in the image, from its principal point [px].
        tilt_away: how far from its mouth a hair dryer's push is stated [m].
        region_stickers: way along each side from one to the next round sticker, on which
            `region_bias` is, and their radius [m]; (0, 0): there are none.
        rounded: share by which the true section is round in place of square.
        rings: amplitude of an error that swings by the square of the way from a place [mm].
        rings_at: where that place is in the image, from its principal point [px].
        rings_radius: way from there over which it swings once [px].
        rings_phase: there [rad].
    """

    stiffening_slant: float = 0.0
    stiffening_steep: float = 0.0
    contrast_until: float = 0.0
    contrast_side: float = 0.0
    mass_shares: tuple[float, ...] = ()
    clamp_preload: float = 0.0
    contact_give: float = 0.0
    depth_entry: float = 0.0
    depth_spacing: float = 1.0
    guy: float = 0.0
    guy_at: float = 0.0
    guy_post: Vector = (0.0, 0.0, 0.0)
    drawn: float = 0.0
    curvature_shares: tuple[float, ...] = ()
    region_places: tuple[float, ...] = ()
    mass_filled: float = 0.0
    contrast_wave: float = 1.0
    contact_ahead: float = 0.0
    contact_round: float = 1.0
    clamp_rub: float = 0.0
    pane: float = 0.0
    pane_normal: Vector = (0.0, 0.0, 1.0)
    crazed: float = 0.0
    skewed: float = 0.0
    clamp_pinch: float = 0.0
    clamp_wedge: float = 0.0
    clamp_crept: float = 0.0
    contact_span: float = 0.0
    contact_drawn: float = 0.0
    contact_tension: float = 0.0
    depth_veil: float = 0.0
    region_bands: tuple[float, float] = (0.0, 0.0)
    worn: float = 0.0
    clipped: float = 0.0
    clipped_near: float = 0.0
    clamp_growth: float = 0.0
    depth_roll: float = 0.0
    imager_tilt: tuple[float, float] = (0.0, 0.0)
    tilt_point: Vector = (0.0, 0.0, 0.0)
    tilt_width: float = 1.0
    magnetized: float = 0.0
    magnetic_way: Vector = (0.0, 0.0, 0.0)
    necked: float = 0.0
    necked_at: float = 0.0
    clamp_slant: float = 0.0
    contact_pressure: float = 0.0
    contact_bend: float = 1.0
    curvature_again: float = 0.0
    curvature_back: float = 0.0
    contrast_pours: tuple[float, ...] = ()
    tilt_above: float = 1.0
    depth_spot: tuple[float, float] = (0.0, 0.0)
    depth_width: float = 1.0
    region_wound: bool = False
    ghost: float = 0.0
    whirl: float = 0.0
    whirl_at: tuple[float, float] = (0.0, 0.0)
    whirl_radius: float = 1.0
    mass_count: int = 0
    clamp_bow: tuple[float, float] = (0.0, 0.0)
    contact_stiffness: float = 0.0
    depth_full: float = 0.0
    region_dot: float = 0.0
    region_cover: float = 0.0
    region_seed: int = 0
    dished: float = 0.0
    fattened: float = 0.0
    mass_ahead: float = 0.0
    clamp_gape: float = 0.0
    contact_wave: float = 1.0
    contact_trough: float = 0.0
    depth_point: Vector = (0.0, 0.0, 0.0)
    region_strip: float = 0.0
    tilt_shares: tuple[float, ...] = ()
    shrinking: float = 0.0
    shrinking_shares: tuple[float, ...] = ()
    bleeding: float = 0.0
    bleeding_width: float = 1.0
    mass_anchor: Vector = (0.0, 0.0, 0.0)
    mass_longer: float = 0.0
    contrast_seed: int = 0
    curvature_waves: float = 0.0
    region_decay: float = 0.0
    center_scatter: tuple[tuple[float, ...], ...] = ()
    unglued: float = 0.0
    trailing: float = 0.0
    trailing_width: float = 1.0
    mass_suction: float = 1.0
    tilt_scatter: tuple[tuple[float, ...], ...] = ()
    depth_slant: float = 0.0
    depth_wander: float = 0.0
    region_sun: tuple[float, float] = (0.0, 0.0)
    updraught: float = 0.0
    updraught_at: tuple[float, float] = (0.0, 0.0)
    updraught_width: float = 1.0
    stuck: float = 0.0
    mass_places: tuple[float, ...] = ()
    contrast_depth: float = 1.0
    clamp_shares: tuple[float, ...] = ()
    region_second: float = 0.0
    region_back: float = 0.0
    tilt_pushes: tuple[Vector, ...] = ()
    curvature_parts: tuple[tuple[float, float], ...] = ()
    flattened: float = 0.0
    combed: float = 0.0
    contrast_creases: tuple[float, ...] = ()
    contrast_width: float = 1.0
    region_shares: tuple[float, ...] = ()
    curvature_prop: float = 0.0
    reeled: float = 0.0
    droplet: float = 0.0
    droplet_at: tuple[float, float] = (0.0, 0.0)
    droplet_width: float = 1.0
    mass_from: int = 0
    depth_shares: tuple[float, ...] = ()
    region_strokes: tuple[float, ...] = ()
    unlevel: float = 0.0
    flicker: float = 0.0
    flicker_period: float = 1.0
    flicker_phases: tuple[float, ...] = ()
    mass_drips: tuple[Vector, ...] = ()
    tilt_back: float = 0.0
    curvature_heavy: float = 0.0
    depth_places: tuple[float, ...] = ()
    region_dips: tuple[float, ...] = ()
    drafted: float = 0.0
    blocky: int = 0
    contact_drops: tuple[float, ...] = ()
    depth_blend: float = 1.0
    region_board: float = 0.0
    ribbed: float = 0.0
    ribbed_waves: float = 1.0
    ribbed_phase: float = 0.0
    mirrored: float = 0.0
    mirrored_at: tuple[float, float] = (0.0, 0.0)
    tilt_away: float = 1.0
    region_stickers: tuple[float, float] = (0.0, 0.0)
    rounded: float = 0.0
    rings: float = 0.0
    rings_at: tuple[float, float] = (0.0, 0.0)
    rings_radius: float = 1.0
    rings_phase: float = 0.0
