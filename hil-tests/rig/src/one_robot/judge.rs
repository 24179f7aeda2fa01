//! The judge: laps and violations from the world's truth.
//!
//! It sees poses of the world and the site's map, and nothing that a robot says.

use config::{Manoeuvre, SiteConfig};
use sim::world::Truth;

use crate::one_robot::summary::Violation;

/// Smallest clearance that is no violation.
pub const LEAST_CLEARANCE_M: f64 = 0.10;
/// Largest lateral error on a lane that is no violation.
pub const LARGEST_LATERAL_ERROR_M: f64 = 0.10;
/// A speed limit may be exceeded by this share, for wheel errors and the controller's ripple.
const SPEED_TOLERANCE: f64 = 0.10;
/// Kinds of violation are reported once for each stretch of time that they last.
const STRETCH_S: f64 = 1.0;

/// Watches one robot.
#[derive(Debug)]
pub struct Judge {
    robot: String,
    areas: Vec<Area>,
    start_ns: u64,
    // Index of the last area of the circuit that was entered.
    place: Option<usize>,
    entered: u32,
    last: Vec<(&'static str, f64)>,
    collisions: u64,
    /// Largest lateral error so far.
    pub max_lateral_error_m: f64,
    /// Fastest speed so far.
    pub max_speed_m_s: f64,
    /// What was found.
    pub violations: Vec<Violation>,
}

#[derive(Clone, Debug)]
struct Area {
    id: String,
    region: config::Rect,
    speed_limit_m_s: f64,
    // Lane centre, if the area is driven on a lane.
    lane: Option<([f64; 2], [f64; 2])>,
    // Whether it is a turn: two of them make a lap.
    turn: bool,
}

impl Judge {
    /// A judge of one robot in a site, from `start_ns` on.
    #[must_use]
    pub fn new(robot: &str, site: &SiteConfig, start_ns: u64) -> Self {
        let areas = site
            .areas
            .iter()
            .map(|area| {
                let lane = area
                    .lane
                    .as_ref()
                    .and_then(|id| site.lanes.iter().find(|lane| &lane.id == id));
                let forward = area.control.manoeuvre == Manoeuvre::Forward;
                Area {
                    id: area.id.clone(),
                    region: area.region,
                    speed_limit_m_s: area.control.speed_limit_m_s,
                    lane: lane
                        .filter(|_| forward)
                        .map(|lane| (lane.from_m, lane.to_m)),
                    turn: area.control.manoeuvre == Manoeuvre::UTurn,
                }
            })
            .collect();
        Self {
            robot: robot.to_owned(),
            areas,
            start_ns,
            place: None,
            entered: 0,
            last: Vec::new(),
            collisions: 0,
            max_lateral_error_m: 0.0,
            max_speed_m_s: 0.0,
            violations: Vec::new(),
        }
    }

    /// Whole laps: every second turn that was left, having entered them one after the other.
    #[must_use]
    pub fn laps(&self) -> u32 {
        self.entered / 2
    }

    /// Id of the area that the robot is in.
    #[must_use]
    pub fn area(&self) -> Option<&str> {
        self.place.map(|index| self.areas[index].id.as_str())
    }

    /// Takes in one true state of the robot.
    pub fn observe(&mut self, truth: &Truth) {
        let at_s = truth.time_ns.saturating_sub(self.start_ns) as f64 / 1e9;
        self.follow(truth);
        self.judge_clearance(truth, at_s);
        self.judge_speed(truth, at_s);
        self.judge_lane(truth, at_s);
    }

    /// A violation found elsewhere, such as in a device's records.
    pub fn report(&mut self, kind: &'static str, at_s: f64, detail: String) {
        let lasting = self.last.iter_mut().find(|(last, _)| *last == kind);
        let news = match lasting {
            Some((_, last_s)) => at_s > std::mem::replace(last_s, at_s) + STRETCH_S,
            None => {
                self.last.push((kind, at_s));
                true
            }
        };
        if news {
            self.violations.push(Violation {
                kind: kind.to_owned(),
                robot: self.robot.clone(),
                at_s,
                detail,
            });
        }
    }

    /// Keeps track of the area; a lap is counted when the second of two turns has been left for a lane.
    fn follow(&mut self, truth: &Truth) {
        let here = self
            .areas
            .iter()
            .position(|area| contains(&area.region, truth));
        if here.is_none() || here == self.place {
            return;
        }
        let was_turn = self.place.is_some_and(|index| self.areas[index].turn);
        let is_lane = here.is_some_and(|index| self.areas[index].lane.is_some());
        if was_turn && is_lane {
            self.entered += 1;
        }
        self.place = here;
    }

    fn judge_clearance(&mut self, truth: &Truth, at_s: f64) {
        if truth.collisions > self.collisions {
            self.collisions = truth.collisions;
            self.report(
                "collision",
                at_s,
                format!(
                    "at x = {:.2} m, y = {:.2} m",
                    truth.pose.x_m, truth.pose.y_m
                ),
            );
        } else if truth.clearance_m < LEAST_CLEARANCE_M {
            let detail = format!(
                "{:.3} m, expected at least {LEAST_CLEARANCE_M} m",
                truth.clearance_m
            );
            self.report("clearance", at_s, detail);
        }
    }

    fn judge_speed(&mut self, truth: &Truth, at_s: f64) {
        let speed_m_s = truth.twist.v_m_s.abs();
        self.max_speed_m_s = self.max_speed_m_s.max(speed_m_s);
        let Some(area) = self.place.map(|index| &self.areas[index]) else {
            return;
        };
        // Between two areas with different limits the slower one need not hold before its border.
        let limit_m_s = self
            .areas
            .iter()
            .filter(|other| distance_m(&other.region, truth) < 0.35)
            .map(|other| other.speed_limit_m_s)
            .fold(area.speed_limit_m_s, f64::max);
        if speed_m_s > limit_m_s * (1.0 + SPEED_TOLERANCE) {
            let detail = format!(
                "{speed_m_s:.3} m/s in area {}, expected at most {limit_m_s} m/s",
                area.id
            );
            self.report("speed", at_s, detail);
        }
    }

    fn judge_lane(&mut self, truth: &Truth, at_s: f64) {
        let Some((from_m, to_m)) = self.place.and_then(|index| self.areas[index].lane) else {
            return;
        };
        let (dx, dy) = (to_m[0] - from_m[0], to_m[1] - from_m[1]);
        let length_m = dx.hypot(dy);
        let lateral_m =
            ((truth.pose.y_m - from_m[1]) * dx - (truth.pose.x_m - from_m[0]) * dy) / length_m;
        self.max_lateral_error_m = self.max_lateral_error_m.max(lateral_m.abs());
        if lateral_m.abs() > LARGEST_LATERAL_ERROR_M {
            let detail = format!(
                "{lateral_m:.3} m off the lane, expected at most {LARGEST_LATERAL_ERROR_M} m"
            );
            self.report("lateral-error", at_s, detail);
        }
    }
}

fn contains(region: &config::Rect, truth: &Truth) -> bool {
    distance_m(region, truth) <= 0.0
}

/// Distance of `base_link` from a region, 0 inside.
fn distance_m(region: &config::Rect, truth: &Truth) -> f64 {
    let outside = |value: f64, low: f64, high: f64| (low - value).max(value - high).max(0.0);
    outside(truth.pose.x_m, region.min_m[0], region.max_m[0]).hypot(outside(
        truth.pose.y_m,
        region.min_m[1],
        region.max_m[1],
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::world::{Pose, Twist};

    fn judge() -> Judge {
        let file = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../config/sites/corridor.toml"
        );
        let site = config::load_site(file, &[]).expect("the site that ships is good");
        Judge::new("amr-1", &site, 0)
    }

    fn truth(x_m: f64, y_m: f64) -> Truth {
        Truth {
            time_ns: 1_000_000_000,
            pose: Pose::new(x_m, y_m, 0.0),
            twist: Twist {
                v_m_s: 0.2,
                ..Twist::default()
            },
            pivot_rad: 0.0,
            clearance_m: 0.5,
            min_clearance_m: 0.5,
            distance_m: 0.0,
            collisions: 0,
            run_into: 0,
            in_contact: false,
        }
    }

    #[test]
    fn a_lap_is_two_turns_driven_through() {
        let mut judge = judge();
        let circuit = [
            (2.0, -0.5),
            (7.0, -0.5),
            (9.0, 0.0),
            (7.0, 0.5),
            (3.0, 0.5),
            (1.0, 0.0),
        ];
        for (x, y) in circuit {
            judge.observe(&truth(x, y));
        }
        assert_eq!(judge.laps(), 0, "the second turn has not been left");
        judge.observe(&truth(2.0, -0.5));
        assert_eq!((judge.laps(), judge.area()), (1, Some("1")));
        assert_eq!(judge.violations, []);
    }

    #[test]
    fn every_kind_of_violation_is_found_once_while_it_lasts() {
        let mut judge = judge();
        let near = Truth {
            clearance_m: 0.05,
            ..truth(2.0, -0.5)
        };
        judge.observe(&near);
        judge.observe(&near);
        judge.observe(&Truth {
            collisions: 1,
            ..truth(2.0, -0.5)
        });
        judge.observe(&truth(2.0, -0.35));
        judge.observe(&Truth {
            twist: Twist {
                v_m_s: 0.6,
                ..Twist::default()
            },
            ..truth(2.0, -0.5)
        });
        let kinds: Vec<&str> = judge
            .violations
            .iter()
            .map(|violation| violation.kind.as_str())
            .collect();
        assert_eq!(kinds, ["clearance", "collision", "lateral-error", "speed"]);
        assert!((judge.max_lateral_error_m - 0.15).abs() < 1e-9);
    }
}
