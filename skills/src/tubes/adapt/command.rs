//! A wanted command: which tube serves it, or why the robot stops.

use super::detour::Moment;
use super::motion_tubes::{Block, MotionTubes};
use super::outcome::{Adapted, Reason, Verdict};
use super::retreat;
use super::room::Room;
use super::select::{Search, Selection, Selector};
use super::speed::AT_REST_M_S;
use description::geometry::{MotionCommand, Twist2};

/// No detour begins while something moves within this distance.
const CROWDED_M: f64 = 1.5;

fn ns(seconds: f64) -> u64 {
    (seconds * 1e9) as u64
}

impl MotionTubes {
    /// What to drive instead of `wanted`, while the robot moves at `current`.
    pub fn adapt(&mut self, wanted: MotionCommand, current: Twist2, now_ns: u64) -> Adapted {
        if !wanted.is_finite() || !current.is_finite() {
            return self.stop(Reason::NotFinite, None, now_ns, now_ns);
        }
        if let Some((reason, since_ns)) = self.sight.look(now_ns) {
            self.driven = None;
            return self.stop(reason, None, since_ns, now_ns);
        }
        let backward = wanted.speed_m_s < 0.0;
        if backward && !self.set.has_backward() {
            return self.stop(Reason::Backwards, None, now_ns, now_ns);
        }
        if wanted.speed_m_s == 0.0 && self.rolls_too_far(wanted, current, now_ns) {
            self.driven = None;
            return self.stop(Reason::TooFast, None, now_ns, now_ns);
        }
        let search = self.search(wanted, now_ns);
        if let Some(adapted) = self.back_out(wanted, current, search, now_ns) {
            return adapted;
        }
        let blocked_ns = self.settle_block(search, wanted, now_ns);
        let selection = match (search, blocked_ns) {
            (Search::Found(selection), None) => selection,
            // A command to stand is not reported as a stop.
            (_, _) if wanted.speed_m_s == 0.0 => return self.rest(wanted, now_ns),
            (Search::Found(_), Some(since_ns)) => {
                return self.stop(Reason::Resuming, None, since_ns, now_ns);
            }
            (Search::Blocked, since_ns) => {
                let since_ns = since_ns.unwrap_or(now_ns);
                let reason = if backward && self.lacks_floor(wanted) {
                    Reason::UnknownFloor
                } else {
                    Reason::Blocked
                };
                return self.stop(reason, None, since_ns, now_ns);
            }
            (Search::BeyondTubes, since_ns) => {
                let since_ns = since_ns.unwrap_or(now_ns);
                return self.stop(Reason::BeyondTubes, None, since_ns, now_ns);
            }
        };
        self.drive(wanted, current, selection, now_ns)
    }

    fn search(&mut self, wanted: MotionCommand, now_ns: u64) -> Search {
        let selector = Selector {
            set: &self.set,
            policy: &self.policy,
            streaks: &self.streaks,
        };
        let moment = Moment {
            now_ns,
            heading_rad: self.odom_pose.theta_rad,
            crowded: self.moving.nearest_m() < CROWDED_M,
            room: self.room,
            known: &self.known,
        };
        let nominal = selector.search(wanted, self.driven);
        if self.by_hand {
            return match nominal {
                Search::Blocked => self.creep_by_hand(wanted).map_or(nominal, Search::Found),
                found => found,
            };
        }
        self.detour.search(&selector, nominal, wanted, moment)
    }

    /// Whether a robot that is told to stand, and rolls on at `current`, has less room than a hard stop takes.
    fn rolls_too_far(&self, wanted: MotionCommand, current: Twist2, now_ns: u64) -> bool {
        if current.v_m_s.abs() <= AT_REST_M_S {
            return false;
        }
        let backward = current.v_m_s < 0.0;
        if backward && !self.set.has_backward() {
            return true;
        }
        let on = MotionCommand::new(current.v_m_s, wanted.curvature_1_m);
        let found = match self.selector().search(on, self.driven) {
            Search::Blocked if self.by_hand => self.creep_by_hand(on),
            Search::Found(selection) => Some(selection),
            _ => None,
        };
        found.is_none_or(|selection| self.is_too_fast(&selection, current, now_ns))
    }

    /// The narrow tube that serves a wanted command, in terms of the set.
    fn creep_by_hand(&self, wanted: MotionCommand) -> Option<Selection> {
        let set = self.set.narrow.as_deref()?;
        let narrow = Selector {
            set,
            policy: &self.policy,
            streaks: &self.narrow_streaks,
        };
        let Search::Found(found) = narrow.search(wanted, None) else {
            return None;
        };
        let row = self.set.slowest(wanted.speed_m_s < 0.0);
        let step = found.tube.0 as usize % set.steps;
        Some(Selection {
            row,
            tube: self.set.id(row, step),
            ..found
        })
    }

    /// What to drive while the robot backs out of a dead end; `None` while it does not.
    fn back_out(
        &mut self,
        wanted: MotionCommand,
        current: Twist2,
        search: Search,
        now_ns: u64,
    ) -> Option<Adapted> {
        let policy = self.policy.detour;
        let wants = wanted.speed_m_s > 0.0 && !self.by_hand;
        let goes = policy.curvature_1_m > 0.0 && wants && self.set.has_backward();
        let blocked = matches!(search, Search::Blocked);
        let moment = retreat::Moment {
            now_ns,
            at: self.odom_pose.position(),
            blocked_since_ns: self.block.filter(|_| blocked).map(|block| block.since_ns),
            moving_m: self.moving.nearest_m(),
        };
        let was_active = self.retreat.is_active();
        if !(goes && self.retreat.goes(&policy, moment)) {
            self.retreat.end();
            return None;
        }
        if !was_active {
            // From there it chooses its way again.
            self.detour.reset_way();
        }
        let slowest_m_s = self.set.rows[self.set.rows.len() - 1].horizon.speed_m_s;
        let left_m = self.retreat.left_m(&policy, moment.at);
        // Straight, or else on the curve that it came on, no tighter than what was checked.
        let tightest_1_m = self
            .room
            .map_or(policy.curvature_1_m, |room| room.tightest_1_m);
        let before_1_m = self.last_curvature_1_m;
        let back = [0.0, before_1_m.max(-tightest_1_m).min(tightest_1_m)].map(|back_1_m| {
            let back = MotionCommand::new(-slowest_m_s, back_1_m);
            let Search::Found(selection) = self.selector().search(back, None) else {
                return None;
            };
            let stays = |room: Room| room.holds_behind(selection.curvature_1_m, left_m);
            self.room.is_none_or(stays).then_some((back, selection))
        });
        let Some((back, selection)) = back[0].or(back[1]) else {
            self.retreat.end();
            return None;
        };
        let adapted = self.drive(back, current, selection, now_ns);
        // It is never what was wanted.
        let verdict = match adapted.verdict {
            Verdict::Stopped => Verdict::Stopped,
            _ => Verdict::Shifted,
        };
        let reason = match adapted.reason {
            Reason::None => Reason::Blocked,
            reason => reason,
        };
        Some(Adapted {
            verdict,
            reason,
            ..adapted
        })
    }

    /// The tube nearest to a wanted command would be free if its floor were known.
    fn lacks_floor(&self, wanted: MotionCommand) -> bool {
        let near = self.surroundings();
        self.selector()
            .nearest_behind(wanted.curvature_1_m)
            .is_some_and(|id| self.set.lacks_floor(id, &self.known, near))
    }

    /// Follows the search into and out of a block; gives since when it has been blocked, while it is.
    fn settle_block(&mut self, search: Search, wanted: MotionCommand, now_ns: u64) -> Option<u64> {
        let wants_to_move = wanted.speed_m_s != 0.0;
        let backward = wanted.speed_m_s < 0.0;
        // Who drives by hand and turns back has seen what stands in the way.
        if self.by_hand && wants_to_move {
            self.block = self.block.filter(|block| block.backward == backward);
        }
        let found = matches!(search, Search::Found(_));
        let Some(block) = &mut self.block else {
            if found || !wants_to_move {
                return None;
            }
            self.counters.blocked_stops += 1;
            self.driven = None;
            self.block = Some(Block {
                backward,
                since_ns: now_ns,
                free_since_ns: None,
            });
            return Some(now_ns);
        };
        if !found {
            block.free_since_ns = None;
            return Some(block.since_ns);
        }
        let free_since_ns = *block.free_since_ns.get_or_insert(now_ns);
        if now_ns.saturating_sub(free_since_ns) >= ns(self.policy.resume_after_s) {
            self.block = None;
            return None;
        }
        Some(block.since_ns)
    }

    fn rest(&mut self, wanted: MotionCommand, now_ns: u64) -> Adapted {
        // Wheels are not turned farther than any tube would.
        let most_1_m = self.set.most_curvature_1_m();
        let curvature_1_m = wanted.curvature_1_m.clamp(-most_1_m, most_1_m);
        Adapted {
            command: MotionCommand::new(0.0, curvature_1_m),
            verdict: Verdict::Free,
            reason: Reason::None,
            stopped_since_ns: 0,
            ..self.stop(Reason::None, None, 0, now_ns)
        }
    }
}
