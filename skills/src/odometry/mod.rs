//! Dead reckoning of a tricycle whose steered wheel unit has a caster.
//!
//! The unit (two hub wheels on a freely turning pivot) sits at (wheelbase, 0) in `base_link`; its wheel axle trails the
//! pivot by the caster offset `s`. With the unit's speed `v_u`, the pivot angle δ and the wheelbase `L`:
//!
//! ```text
//! v    = v_u·cos δ − s·(ω + δ')·sin δ
//! ω·L  = v_u·sin δ + s·(ω + δ')·cos δ
//! ```
//!
//! `v_u` comes from the sum of both wheels, δ and δ' from the pivot encoder. The difference of the wheels would give
//! ω + δ' too, but magnifies a scale error of one per cent into a drifting heading; it only serves to recognise a pivot
//! encoder that jumps.
//!
//! Real time: [`DeadReckoning::update`] does not allocate, lock or panic.
//!
//! ```
//! use description::robot::TricycleGeometry;
//! use description::wheels::EncoderAngles;
//! use skills::odometry::{DeadReckoning, EncoderSample};
//! let mut dead_reckoning = DeadReckoning::new(TricycleGeometry::default(), 35.0)?;
//! let wheel_rad_per_m = 1.0 / TricycleGeometry::default().wheel_radius_m();
//! for step in 0..=100u64 {
//!     let travelled_rad = step as f64 * 0.002 * wheel_rad_per_m;
//!     let angles = EncoderAngles { left_rad: travelled_rad, right_rad: travelled_rad, pivot_rad: 0.0 };
//!     let sample = EncoderSample { stamp_ns: 1 + step * 5_000_000, angles };
//!     dead_reckoning.update(&sample)?;
//! }
//! assert!((dead_reckoning.odometry().pose.x_m - 0.2).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod estimate;
mod refused;
mod slip;

use description::geometry::{Twist2, wrap_angle};
use description::keys::KeyError;
use description::robot::TricycleGeometry;
use description::wheels::EncoderAngles;
use slip::{SlipStep, SlipWatch};

pub use estimate::{EncoderSample, Odometry};
pub use refused::{OdometryCounters, OdometryFault};
pub use slip::Slip;

/// Longest step that is bridged with the last twist when a sample has to be rejected.
const BRIDGE_S: f64 = 0.05;
/// After a gap longer than this, values that are not possible are taken as they are, without moving.
const LONGEST_GAP_S: f64 = 5.0;
/// However long the gap, a robot does not drive for longer in it: its drive stops without setpoints.
const LONGEST_MOTION_S: f64 = 1.0;
/// Within this time nobody pushes a robot that has lost its power,
const UNSEEN_S: f64 = 0.5;
/// and a way up to this, which it rolls on, is within the margins of everything that is remembered of the floor.
const UNSEEN_M: f64 = 0.05;
/// Farther than anybody pushes a robot: what says so has begun to count anew.
const FURTHEST_M: f64 = 100.0;
/// A pivot that has turned by this between two samples far apart may have pointed anywhere meanwhile.
const ANYWHERE_RAD: f64 = 1.0;
/// After this many stamps in a row before the last accepted one, the clock counts as set back.
const BACKWARD_RUN: u32 = 20;
/// Pivot rate that a hand or a bump can add to that of the wheels, rad/s.
const FASTEST_PIVOT_RAD_S: f64 = 80.0;
/// Time constant of the published twist, s.
const TWIST_FILTER_S: f64 = 0.01;

/// What two samples differ by.
struct Increments {
    /// Way of the unit.
    unit_m: f64,
    /// Turn of the pivot.
    pivot_rad: f64,
    /// How the wheels' ways differ.
    slip: SlipStep,
}

/// Integrates encoder samples into a pose in `odom`.
#[derive(Clone, Debug)]
pub struct DeadReckoning {
    geometry: TricycleGeometry,
    max_wheel_speed_rad_s: f64,
    odometry: Odometry,
    last: Option<EncoderSample>,
    slip: SlipWatch,
    /// Since when the way is not measured, and how the robot moved then.
    unmeasured: Option<(u64, Twist2)>,
    backward_run: u32,
    counters: OdometryCounters,
}

impl DeadReckoning {
    /// Starts at the origin of `odom`. The wheel speed limit tells possible increments from jumps.
    ///
    /// # Errors
    /// The first key of `[drive]` that describes no vehicle.
    pub fn new(geometry: TricycleGeometry, max_wheel_speed_rad_s: f64) -> Result<Self, KeyError> {
        geometry.validate()?;
        if !(max_wheel_speed_rad_s.is_finite() && max_wheel_speed_rad_s > 0.0) {
            let found = format!("{max_wheel_speed_rad_s:?}");
            let key = "drive.max_wheel_speed_rad_s";
            return Err(KeyError::new(key, found, "a speed above 0 rad/s"));
        }
        Ok(Self {
            geometry,
            max_wheel_speed_rad_s,
            odometry: Odometry::default(),
            last: None,
            slip: SlipWatch::default(),
            unmeasured: None,
            backward_run: 0,
            counters: OdometryCounters::default(),
        })
    }

    /// Goes on from what was reckoned before by another, of the same drive, whose encoders have counted on since.
    pub fn resume(&mut self, before: &Odometry) {
        self.odometry = Odometry {
            twist: Twist2::default(),
            ..*before
        };
        self.last = Some(EncoderSample {
            stamp_ns: before.stamp_ns,
            angles: before.angles,
        });
    }

    /// The latest estimate.
    #[must_use]
    pub fn odometry(&self) -> &Odometry {
        &self.odometry
    }

    /// The wheels slip, as far as can be seen.
    #[must_use]
    pub fn slips(&self) -> bool {
        self.slip.slips()
    }

    /// Which wheel slips, while one does: what was expected of it and what was found.
    #[must_use]
    pub fn slip(&self) -> Option<Slip> {
        self.slip.found()
    }

    /// Looks anew whether the wheels slip.
    pub fn forget_slip(&mut self) {
        self.slip = SlipWatch::default();
    }

    /// Samples used and rejected since the start.
    #[must_use]
    pub fn counters(&self) -> OdometryCounters {
        self.counters
    }

    /// Takes the next sample as a new beginning: after the encoders restarted. How the robot has moved meanwhile they do not say.
    pub fn rebase(&mut self) {
        if let Some(last) = self.last.take() {
            self.unmeasured = Some((last.stamp_ns, self.odometry.twist));
        }
        self.odometry.twist = Twist2::default();
    }

    /// Moves the estimate by one sample. A rejected sample is counted; the estimate stays usable.
    ///
    /// # Errors
    /// Why the sample was not used; the estimate stays usable.
    pub fn update(&mut self, sample: &EncoderSample) -> Result<Odometry, OdometryFault> {
        let stamp_ns = sample.stamp_ns;
        let EncoderAngles {
            left_rad,
            right_rad,
            pivot_rad,
        } = sample.angles;
        if ![left_rad, right_rad, pivot_rad]
            .iter()
            .all(|value| value.is_finite())
        {
            self.counters.not_finite += 1;
            return Err(OdometryFault::NotFinite { stamp_ns });
        }
        let Some(last) = self.last else {
            self.begin(sample);
            return Ok(self.odometry);
        };
        if stamp_ns < last.stamp_ns {
            self.counters.time_backwards += 1;
            self.backward_run += 1;
            if self.backward_run >= BACKWARD_RUN {
                self.begin(sample);
            }
            let by_ns = last.stamp_ns - stamp_ns;
            return Err(OdometryFault::TimeBackwards { by_ns });
        }
        self.backward_run = 0;
        if stamp_ns == last.stamp_ns {
            self.counters.repeated += 1;
            return Ok(self.odometry);
        }
        let dt_s = (stamp_ns - last.stamp_ns) as f64 * 1e-9;
        match self.increments(&last.angles, &sample.angles, dt_s) {
            Ok(Increments {
                unit_m,
                pivot_rad,
                slip,
            }) => {
                self.integrate(unit_m, pivot_rad, dt_s);
                // Where the unit pointed in between is a guess.
                if dt_s > LONGEST_MOTION_S {
                    let way_m = unit_m.abs() * (pivot_rad.abs() / ANYWHERE_RAD).min(1.0);
                    if way_m > UNSEEN_M {
                        self.lose_track(way_m);
                    }
                }
                self.odometry.slipped_m += self.slip.step(slip);
                self.counters.accepted += 1;
                self.last = Some(*sample);
                self.stamp(sample);
                self.odometry.refused = self.counters.rejected();
                Ok(self.odometry)
            }
            Err(_) if dt_s > LONGEST_GAP_S => {
                self.counters.gaps += 1;
                self.lose_track(self.way_m(&last.angles, &sample.angles));
                self.begin(sample);
                Err(OdometryFault::Gap { gap_s: dt_s })
            }
            Err(fault) => {
                self.counters.jumps += 1;
                self.bridge(dt_s);
                if dt_s > BRIDGE_S {
                    let fastest_m_s = self.max_wheel_speed_rad_s * self.geometry.wheel_radius_m();
                    self.lose_track(match dt_s > LONGEST_MOTION_S {
                        true => self.way_m(&last.angles, &sample.angles),
                        false => fastest_m_s * dt_s,
                    });
                }
                // The new values are the base of what follows: a jump that stays is rejected only once.
                self.last = Some(*sample);
                self.odometry.stamp_ns = stamp_ns;
                self.odometry.angles = sample.angles;
                Err(fault)
            }
        }
    }

    /// What the unit has rolled between two samples, if no encoder has wrapped.
    fn way_m(&self, last: &EncoderAngles, sample: &EncoderAngles) -> f64 {
        let turned_rad = sample.left_rad - last.left_rad + sample.right_rad - last.right_rad;
        self.geometry.wheel_radius_m() * turned_rad.abs() / 2.0
    }

    /// The robot has moved by about this way, and nobody knows whereto.
    fn lose_track(&mut self, way_m: f64) {
        self.odometry.unmeasured_m += way_m.min(FURTHEST_M);
        self.odometry.breaks += 1;
    }

    fn begin(&mut self, sample: &EncoderSample) {
        if let Some((since_ns, twist)) = self.unmeasured.take() {
            let gap_s = sample.stamp_ns.saturating_sub(since_ns) as f64 * 1e-9;
            if gap_s <= UNSEEN_S && twist.v_m_s.abs() * gap_s <= UNSEEN_M {
                self.roll_on(twist, gap_s);
            } else {
                self.odometry.breaks += 1;
            }
        }
        self.last = Some(*sample);
        self.backward_run = 0;
        self.stamp(sample);
        self.odometry.twist = Twist2::default();
    }

    fn stamp(&mut self, sample: &EncoderSample) {
        self.odometry.stamp_ns = sample.stamp_ns;
        self.odometry.steering_rad = wrap_angle(sample.angles.pivot_rad);
        self.odometry.angles = sample.angles;
    }

    /// What has happened since the last sample, when it is possible.
    fn increments(
        &self,
        last: &EncoderAngles,
        sample: &EncoderAngles,
        dt_s: f64,
    ) -> Result<Increments, OdometryFault> {
        // A fifth above the limit: the drive's speed loop overshoots.
        let driven_s = dt_s.min(LONGEST_MOTION_S);
        let limit_rad = 1.2 * self.max_wheel_speed_rad_s * driven_s + 0.02;
        // After a long gap nobody knows whether an encoder has wrapped.
        let possible = |raw_rad: f64| {
            let wraps = dt_s <= LONGEST_MOTION_S && raw_rad.abs() > limit_rad;
            if wraps { wrap_angle(raw_rad) } else { raw_rad }
        };
        let left_rad = possible(sample.left_rad - last.left_rad);
        let right_rad = possible(sample.right_rad - last.right_rad);
        if left_rad.abs() > limit_rad || right_rad.abs() > limit_rad {
            return Err(OdometryFault::WheelJump {
                left_rad,
                right_rad,
                limit_rad,
            });
        }
        let radius_m = self.geometry.wheel_radius_m();
        let unit_m = radius_m * (left_rad + right_rad) / 2.0;
        let moved_rad = wrap_angle(sample.pivot_rad - last.pivot_rad);
        let turn_rad = radius_m * (right_rad - left_rad) / self.geometry.wheel_separation_m;
        let body_rad = self
            .geometry
            .twist(unit_m, last.pivot_rad + moved_rad / 2.0, moved_rad)
            .omega_rad_s;
        let explained_rad = turn_rad - body_rad;
        // Slip and sampling at slightly different moments; beyond that it is the encoder.
        let tolerance_rad = 0.15 + 0.3 * turn_rad.abs() + 4.0 * dt_s;
        if moved_rad.abs() > FASTEST_PIVOT_RAD_S * dt_s
            || (dt_s < 0.5 && (moved_rad - explained_rad).abs() > tolerance_rad)
        {
            return Err(OdometryFault::PivotJump {
                moved_rad,
                explained_rad,
            });
        }
        let separation_m = self.geometry.wheel_separation_m;
        Ok(Increments {
            unit_m,
            pivot_rad: moved_rad,
            slip: SlipStep {
                rim_m: radius_m * (left_rad.abs() + right_rad.abs()) / 2.0,
                unit_m,
                explained_m: (body_rad + moved_rad) * separation_m,
                unexplained_m: (explained_rad - moved_rad) * separation_m,
            },
        })
    }

    fn integrate(&mut self, unit_m: f64, pivot_rad: f64, dt_s: f64) {
        let middle_rad = self.odometry.steering_rad + pivot_rad / 2.0;
        let step = self.geometry.twist(unit_m, middle_rad, pivot_rad);
        self.advance(step);
        let weight = dt_s / (dt_s + TWIST_FILTER_S);
        let twist = &mut self.odometry.twist;
        twist.v_m_s += weight * (step.v_m_s / dt_s - twist.v_m_s);
        twist.omega_rad_s += weight * (step.omega_rad_s / dt_s - twist.omega_rad_s);
    }

    /// Continues with the last twist for the short time that a rejected sample covers.
    fn bridge(&mut self, dt_s: f64) {
        let twist = self.odometry.twist;
        let bridged_s = dt_s.min(BRIDGE_S);
        self.advance(Twist2::new(
            twist.v_m_s * bridged_s,
            twist.omega_rad_s * bridged_s,
        ));
    }

    /// For a moment without power: it may have stopped at once, or gone on as it moved. In between is half of that, give or take as much.
    fn roll_on(&mut self, twist: Twist2, gap_s: f64) {
        let [way_m, turned_rad] = [twist.v_m_s, twist.omega_rad_s].map(|rate| 0.5 * gap_s * rate);
        self.advance(Twist2::new(way_m, turned_rad));
        self.odometry.unmeasured_m += way_m.abs().max(turned_rad.abs());
    }

    /// `step`: metres and radians.
    fn advance(&mut self, step: Twist2) {
        self.odometry.pose = self.odometry.pose.advance(step, 1.0);
        self.odometry.distance_m += step.v_m_s.abs();
        self.odometry.turned_rad += step.omega_rad_s.abs();
    }
}

#[cfg(test)]
mod tests;
