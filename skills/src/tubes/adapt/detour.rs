//! The way around an obstacle that stands where the robot wants to go.
//!
//! The narrow band of `select` keeps the lane; a box on the lane needs more. When the wanted command stays hindered, a
//! detour begins: in the longest row that has a free tube, the one nearest to the wanted curvature is driven, slowly.
//! Since navigation steers back to its lane, that tube follows the side of the obstacle, and behind it the lane.
//!
//! A detour keeps to the side that it began on, and turns no farther than a limit away from the path that it is to keep
//! to, or, where it knows none, from the direction in which the robot last drove freely: so that it does
//! not turn back before a wall across the corridor. Nor does it leave the [`Room`] beside that path. It ends when the wanted curvature
//! is free for a good way. It never leads backwards. While something moves nearby the robot stays where it still has room
//! to turn, and waits for a while before it begins one.

use super::room::Room;
use super::select::{Search, Selection, Selector};
use crate::tubes::memory::known::KnownRanges;
use description::geometry::{MotionCommand, wrap_angle};
use description::robot::DetourPolicy;

/// A detour ends when the wanted way has been free this long.
const FREE_NS: u64 = 250_000_000;
/// Within this time of a detour, resume it if the way is blocked again, however slow the wanted motion.
const RECENT_NS: u64 = 4_000_000_000;
/// A hindrance is forgotten after this time without it: the end of a tube at an obstacle flickers.
const UNHINDERED_NS: u64 = 500_000_000;
/// After this time without a free tube on its side, the other side is tried.
const STUCK_NS: u64 = 2_000_000_000;
/// Timeout of waiting for what moves nearby.
const PATIENCE_NS: u64 = 4_000_000_000;
/// The robot is hindered when the free speed is this much below the wanted one.
const HINDERED_M_S: f64 = 0.05;

#[derive(Clone, Copy, Debug)]
struct Active {
    /// +1: to the left of what is wanted; −1: to the right; 0: not chosen yet.
    side: f64,
    free_since_ns: Option<u64>,
    stuck_since_ns: Option<u64>,
}

/// The state of going around things.
#[derive(Clone, Debug, Default)]
pub(super) struct Detour {
    active: Option<Active>,
    hindered_since_ns: Option<u64>,
    /// Last time that it was hindered.
    hindered_ns: u64,
    ended_ns: Option<u64>,
    /// It waits for what moves nearby.
    waits: bool,
    /// In `odom`, when it last drove as wanted.
    heading_rad: Option<f64>,
    /// Detours begun, and how often one changed sides.
    pub begun: u64,
    pub changed_sides: u64,
}

/// Inputs of one step of a detour.
#[derive(Clone, Copy)]
pub(super) struct Moment<'a> {
    pub now_ns: u64,
    /// Of `base_link` in `odom` on the newest scan.
    pub heading_rad: f64,
    /// Something moves nearby.
    pub crowded: bool,
    /// About the path that it is to keep to.
    pub room: Option<Room>,
    /// The newest scan.
    pub known: &'a KnownRanges,
}

impl Detour {
    pub fn is_active(&self) -> bool {
        self.active.is_some()
    }

    /// The robot is to stay where it is until what moves nearby has gone.
    pub fn waits(&self) -> bool {
        self.waits
    }

    /// Forgets the way, not the counts.
    pub fn reset(&mut self) {
        *self = Self {
            begun: self.begun,
            changed_sides: self.changed_sides,
            ..Self::default()
        };
    }

    /// Drops the chosen way; another may be chosen.
    pub fn reset_way(&mut self) {
        self.active = None;
        self.waits = false;
    }

    /// What to drive, given what was found near to the wanted command.
    pub fn search(
        &mut self,
        selector: &Selector<'_>,
        nominal: Search,
        wanted: MotionCommand,
        moment: Moment<'_>,
    ) -> Search {
        self.waits = false;
        let policy = &selector.policy.detour;
        let beyond = matches!(nominal, Search::BeyondTubes);
        if policy.curvature_1_m <= 0.0 || wanted.speed_m_s <= 0.0 || beyond {
            self.active = None;
            self.hindered_since_ns = None;
            return nominal;
        }
        let is_clear = selector.is_clear(wanted.curvature_1_m);
        let Some(active) = &mut self.active else {
            let recent = self
                .ended_ns
                .is_some_and(|ended_ns| moment.now_ns.saturating_sub(ended_ns) < RECENT_NS);
            let hindered = is_hindered(selector, nominal, wanted) || (recent && !is_clear);
            if hindered {
                self.hindered_ns = moment.now_ns;
            }
            let was_hindered = self.hindered_since_ns.is_some()
                && moment.now_ns.saturating_sub(self.hindered_ns) < UNHINDERED_NS;
            if !hindered && !was_hindered {
                self.hindered_since_ns = None;
                let unshifted =
                    matches!(nominal, Search::Found(selection) if selection.shift_1_m == 0.0);
                if self.heading_rad.is_none() || (unshifted && is_clear) {
                    self.heading_rad = Some(moment.heading_rad);
                }
                return nominal;
            }
            let since_ns = *self.hindered_since_ns.get_or_insert(moment.now_ns);
            let hindered_ns = moment.now_ns.saturating_sub(since_ns);
            self.waits = moment.crowded && hindered_ns < PATIENCE_NS;
            if self.waits || !hindered || (hindered_ns < (policy.after_s * 1e9) as u64 && !recent) {
                return nominal;
            }
            self.begun += 1;
            self.active = Some(Active {
                side: 0.0,
                free_since_ns: None,
                stuck_since_ns: None,
            });
            return self.go_on(selector, wanted, moment);
        };
        if !is_clear {
            active.free_since_ns = None;
        } else {
            let since_ns = *active.free_since_ns.get_or_insert(moment.now_ns);
            if moment.now_ns.saturating_sub(since_ns) >= FREE_NS {
                self.active = None;
                self.hindered_since_ns = None;
                self.ended_ns = Some(moment.now_ns);
                return nominal;
            }
        }
        self.go_on(selector, wanted, moment)
    }

    fn go_on(&mut self, selector: &Selector<'_>, wanted: MotionCommand, moment: Moment) -> Search {
        let Some(active) = &mut self.active else {
            return Search::Blocked;
        };
        let before_rad = self.heading_rad.unwrap_or(moment.heading_rad);
        let off_rad = moment.room.map_or_else(
            || wrap_angle(moment.heading_rad - before_rad),
            |room| room.heading_rad,
        );
        let left = longest(selector, wanted, off_rad, moment.room, 1.0);
        let right = longest(selector, wanted, off_rad, moment.room, -1.0);
        let (found, other) = match active.side {
            side if side > 0.0 => (left, right),
            side if side < 0.0 => (right, left),
            _ => {
                let opening = opening(selector, moment.known, off_rad);
                let of_opening = if opening > 0.0 { left } else { right };
                let chosen = of_opening.filter(|_| opening != 0.0);
                (chosen.or_else(|| better(left, right)), None)
            }
        };
        if let Some(selection) = found {
            active.stuck_since_ns = None;
            if active.side == 0.0 && selection.shift_1_m != 0.0 {
                active.side = selection.shift_1_m.signum();
            }
            return Search::Found(selection);
        }
        let since_ns = *active.stuck_since_ns.get_or_insert(moment.now_ns);
        let stuck_ns = moment.now_ns.saturating_sub(since_ns);
        if let Some(selection) = other
            && stuck_ns >= STUCK_NS
        {
            active.side = -active.side;
            active.stuck_since_ns = None;
            self.changed_sides += 1;
            return Search::Found(selection);
        }
        Search::Blocked
    }
}

/// The free way is much slower than wanted, or there is none.
fn is_hindered(selector: &Selector<'_>, nominal: Search, wanted: MotionCommand) -> bool {
    match nominal {
        Search::Found(selection) => {
            let free_m_s = selector.speed_m_s(&selection);
            free_m_s <= selector.policy.detour.speed_m_s
                && free_m_s + HINDERED_M_S < wanted.speed_m_s
        }
        Search::Blocked => true,
        Search::BeyondTubes => false,
    }
}

/// Of the longest row that has one, a free tube on one side of what is wanted: of a long row the nearest; of a short one,
/// in which it would soon stand before the thing, the one that turns away most.
fn longest(
    selector: &Selector<'_>,
    wanted: MotionCommand,
    off_rad: f64,
    room: Option<Room>,
    side: f64,
) -> Option<Selection> {
    let policy: &DetourPolicy = &selector.policy.detour;
    let path_1_m = room.map_or(0.0, |room| room.path_curvature_1_m);
    let allowed = |selection: &Selection| {
        let end_rad = off_rad + (selection.curvature_1_m - path_1_m) * selection.length_m;
        let turns_back = off_rad.abs() > policy.heading_rad && end_rad.abs() < off_rad.abs();
        selection.curvature_1_m.abs() <= policy.curvature_1_m
            && (end_rad.abs() <= policy.heading_rad || turns_back)
            && room.is_none_or(|room| room.holds(selection.curvature_1_m, selection.length_m))
    };
    let wanted_1_m = wanted.curvature_1_m;
    selector.ahead().find_map(|row| {
        if selector.is_long(row) {
            selector.nearest_on_side(row, wanted_1_m, side, allowed)
        } else {
            selector.farthest_on_side(row, wanted_1_m, side, allowed)
        }
    })
}

/// The side on which a strip as wide as the robot, and as long as the longest tube, opens first; or else a shorter one.
/// +1 left, −1 right, 0 when both do, or none.
fn opening(selector: &Selector<'_>, known: &KnownRanges, off_rad: f64) -> f64 {
    const STEP_RAD: f64 = 0.1;
    let set = selector.set;
    let body = set.footprint();
    let half_width_m = body.left_m.max(body.right_m) + set.parameters().augment_m;
    // Directions along the obstacle itself are no opening.
    let widest_rad = selector.policy.detour.heading_rad.min(1.0);
    let steps = (widest_rad / STEP_RAD) as usize;
    for share in [1.0, 0.8, 0.6] {
        let needed_m = body.front_m + share * set.rows[0].length_m;
        for step in 1..=steps {
            let open = |side: f64| {
                let direction_rad = side * STEP_RAD * step as f64 - off_rad;
                known.strip_m(direction_rad, half_width_m) >= needed_m
            };
            match (open(1.0), open(-1.0)) {
                (true, false) => return 1.0,
                (false, true) => return -1.0,
                (true, true) => return 0.0,
                (false, false) => {}
            }
        }
    }
    0.0
}

/// The one in the longer row; of equals the one with the smaller shift.
fn better(left: Option<Selection>, right: Option<Selection>) -> Option<Selection> {
    match (left, right) {
        (Some(left), Some(right)) => {
            let prefers_left = left.row < right.row
                || (left.row == right.row && left.shift_1_m.abs() <= right.shift_1_m.abs());
            Some(if prefers_left { left } else { right })
        }
        (one, other) => one.or(other),
    }
}
