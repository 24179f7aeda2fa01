//! The search along a path for the first forbidden place.

use super::set::AreaSet;
use description::areas::AreaIndex;
use description::geometry::{Footprint, MotionCommand, Point2, Pose2, Rect, wrap_angle};
use nalgebra::{Matrix3, Vector3};

/// A smaller gap counts as contact, so that the search terminates.
const TOUCH_M: f64 = 0.004;
/// The search for one area looks at this many poses at most; the rest of the path counts as not cleared.
const LOOKS: u32 = 1000;

/// How far to keep from what is forbidden.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BorderGains {
    /// Growth of the footprint, in standard deviations of the pose,
    pub sigmas: f64,
    /// plus what that does not count, since map or lidar are wrong alike in all scans,
    pub map_error_m: f64,
    /// plus this margin.
    pub margin_m: f64,
}

impl BorderGains {
    /// Growth of the footprint whatever the standard deviations of the pose.
    #[must_use]
    pub fn fixed_m(&self) -> f64 {
        self.map_error_m + self.margin_m
    }
}

impl Default for BorderGains {
    fn default() -> Self {
        Self {
            sigmas: 3.0,
            map_error_m: 0.0,
            margin_m: 0.01,
        }
    }
}

/// A path of constant curvature from where the robot stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// Turning per metre driven forward, positive to the left.
    pub curvature_1_m: f64,
    /// How far to look; negative: backward.
    pub reach_m: f64,
}

/// What lies on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BorderVerdict {
    /// Way of `base_link` along the path until the first forbidden place; the whole way looked at when there is none.
    pub distance_m: f64,
    /// The area that would be entered there; none: the path is free as far as it was looked at.
    pub area: Option<AreaIndex>,
    /// The bare footprint, at the estimated pose, is in a forbidden area already (`area` names it, the distance is 0).
    pub inside: bool,
}

impl BorderVerdict {
    /// Fastest speed from which the robot stops before the border, when it begins to brake after `delay_s`.
    ///
    /// Infinite when nothing is in the way within what was looked at: look at least the stopping distance ahead.
    #[must_use]
    pub fn speed_limit_m_s(&self, deceleration_m_s2: f64, delay_s: f64) -> f64 {
        if self.area.is_none() {
            return f64::INFINITY;
        }
        let root = delay_s * delay_s + 2.0 * self.distance_m / deceleration_m_s2;
        (deceleration_m_s2 * (root.max(0.0).sqrt() - delay_s)).max(0.0)
    }
}

/// Watches the borders of one map's areas for one footprint.
#[derive(Clone, Debug)]
pub struct BorderGuard {
    regions: Box<[Rect]>,
    footprint: Footprint,
    gains: BorderGains,
}

impl BorderGuard {
    /// A guard of the areas, by their index in the map.
    #[must_use]
    pub fn new(
        regions: impl IntoIterator<Item = Rect>,
        footprint: Footprint,
        gains: BorderGains,
    ) -> Self {
        Self {
            regions: regions.into_iter().collect(),
            footprint,
            gains,
        }
    }

    /// Looks along a curve from the estimated pose.
    #[must_use]
    pub fn along_curve(
        &self,
        allowed: &AreaSet,
        pose: Pose2,
        covariance: &Matrix3<f64>,
        curve: Curve,
    ) -> BorderVerdict {
        let sign = if curve.reach_m < 0.0 { -1.0 } else { 1.0 };
        let unit = MotionCommand::new(sign, curve.curvature_1_m).twist();
        let path = Path {
            place: |way_m| pose.advance(unit, way_m),
            length_m: curve.reach_m.abs(),
            // A point of the body moves faster than `base_link` when the robot turns.
            stretch: 1.0 + curve.curvature_1_m.abs() * self.footprint.radius_m(),
        };
        let watched = match self.watch(allowed, pose, covariance, path.length_m) {
            Watch::Areas(watched) => watched,
            Watch::Stop(verdict) => return verdict,
        };
        self.judge(&watched, covariance, &path)
    }

    /// Looks along poses in `map`, straight from the estimated pose to the first and from each to the next.
    #[must_use]
    pub fn along_poses<I>(
        &self,
        allowed: &AreaSet,
        pose: Pose2,
        covariance: &Matrix3<f64>,
        poses: I,
    ) -> BorderVerdict
    where
        I: IntoIterator<Item = Pose2, IntoIter: Clone>,
    {
        let poses = poses.into_iter();
        let mut length_m = 0.0;
        let mut from = pose;
        for to in poses.clone() {
            length_m += from.position().distance_m(to.position());
            from = to;
        }
        let watched = match self.watch(allowed, pose, covariance, length_m) {
            Watch::Areas(watched) => watched,
            Watch::Stop(verdict) => return verdict,
        };
        let radius_m = self.footprint.radius_m();
        let mut driven_m = 0.0;
        let mut from = pose;
        for to in std::iter::once(pose).chain(poses) {
            let length_m = from.position().distance_m(to.position());
            let turn_rad = wrap_angle(to.theta_rad - from.theta_rad).abs();
            // A turn on the spot has a way of its own.
            let way_m = length_m.max(turn_rad * radius_m);
            let stands = way_m <= 0.0;
            let path = Path {
                place: |at_m: f64| {
                    if stands {
                        to
                    } else {
                        from.interpolate(to, at_m / way_m)
                    }
                },
                length_m: way_m,
                stretch: if stands {
                    1.0
                } else {
                    (length_m + turn_rad * radius_m) / way_m
                },
            };
            let verdict = self.judge(&watched, covariance, &path);
            if verdict.area.is_some() {
                let share = if stands {
                    0.0
                } else {
                    verdict.distance_m / way_m
                };
                return BorderVerdict {
                    distance_m: driven_m + share * length_m,
                    ..verdict
                };
            }
            driven_m += length_m;
            from = to;
        }
        BorderVerdict {
            // Poses that are no numbers lead nowhere, even where every area is allowed.
            distance_m: if driven_m.is_finite() { driven_m } else { 0.0 },
            area: None,
            inside: false,
        }
    }

    /// Which areas are worth following a path for, or why not to start at all.
    fn watch(
        &self,
        allowed: &AreaSet,
        pose: Pose2,
        covariance: &Matrix3<f64>,
        length_m: f64,
    ) -> Watch {
        let sound = pose.is_finite()
            && covariance.iter().all(|number| number.is_finite())
            && length_m.is_finite();
        let angle_rad = self.gains.sigmas * covariance[(2, 2)].max(0.0).sqrt();
        let spread = (covariance[(0, 0)] + covariance[(1, 1)]).max(0.0).sqrt();
        // Farther away than this nothing is touched.
        let reach_m = length_m
            + self.footprint.radius_m() * (1.0 + angle_rad + angle_rad * angle_rad)
            + self.gains.sigmas * spread
            + self.gains.fixed_m()
            + TOUCH_M;
        let mut watched = AreaSet::EMPTY;
        for (place, region) in self.regions.iter().enumerate() {
            // Those that a set cannot hold are watched by standing still.
            let area = AreaIndex::new(place);
            if area.is_some_and(|area| allowed.contains(area)) {
                continue;
            }
            let stop = |inside| {
                Watch::Stop(BorderVerdict {
                    distance_m: 0.0,
                    area: Some(area.unwrap_or(AreaIndex(u8::MAX))),
                    inside,
                })
            };
            if !sound {
                return stop(false);
            }
            if region.distance_m(pose.position()) > reach_m {
                continue;
            }
            let Some(area) = area else {
                return stop(false);
            };
            if self.bare_region_gap_m(region, pose) < 0.0 {
                return stop(true);
            }
            watched.insert(area);
        }
        Watch::Areas(watched)
    }

    fn judge<P: Fn(f64) -> Pose2>(
        &self,
        watched: &AreaSet,
        covariance: &Matrix3<f64>,
        path: &Path<P>,
    ) -> BorderVerdict {
        let mut verdict = BorderVerdict {
            distance_m: path.length_m,
            area: None,
            inside: false,
        };
        for area in watched.iter() {
            let region = &self.regions[area.place()];
            if let Some(entry_m) = self.entry_m(region, covariance, path, verdict.distance_m)
                && (verdict.area.is_none() || entry_m < verdict.distance_m)
            {
                verdict.distance_m = entry_m;
                verdict.area = Some(area);
            }
        }
        verdict
    }

    /// How far along the path the region is first touched, if within `upto_m`.
    fn entry_m<P: Fn(f64) -> Pose2>(
        &self,
        region: &Rect,
        covariance: &Matrix3<f64>,
        path: &Path<P>,
        upto_m: f64,
    ) -> Option<f64> {
        let mut way_m = 0.0;
        for _ in 0..LOOKS {
            let gap_m = self.gap_m(region, covariance, (path.place)(way_m));
            // Also true for what is not a number.
            if gap_m.is_nan() || gap_m < TOUCH_M {
                return Some(way_m);
            }
            if way_m >= upto_m {
                return None;
            }
            // No point of the body gets farther than the gap on this way.
            way_m = (way_m + gap_m / path.stretch).min(upto_m);
        }
        Some(way_m)
    }

    fn gap_m(&self, region: &Rect, covariance: &Matrix3<f64>, pose: Pose2) -> f64 {
        gap_m(&self.footprint, &self.gains, region, covariance, pose)
    }

    /// From the footprint as it is to an area; less than 0 by how deep it lies in it. Infinite for an area that is none.
    #[must_use]
    pub fn bare_gap_m(&self, area: AreaIndex, pose: Pose2) -> f64 {
        let region = self.regions.get(area.place());
        region.map_or(f64::INFINITY, |region| self.bare_region_gap_m(region, pose))
    }

    fn bare_region_gap_m(&self, region: &Rect, pose: Pose2) -> f64 {
        let bare = BorderGains {
            sigmas: 0.0,
            map_error_m: 0.0,
            margin_m: 0.0,
        };
        gap_m(&self.footprint, &bare, region, &Matrix3::zeros(), pose)
    }
}

/// A way for `base_link`.
struct Path<P> {
    /// The pose after a way.
    place: P,
    length_m: f64,
    /// No point of the body moves more than this for each metre of way.
    stretch: f64,
}

/// What stands between a robot and looking ahead.
enum Watch {
    /// Nothing; these areas are near enough to matter.
    Areas(AreaSet),
    /// It must not move at all.
    Stop(BorderVerdict),
}

/// A lower bound of the distance between the region and the grown footprint; negative when they may overlap.
fn gap_m(
    footprint: &Footprint,
    gains: &BorderGains,
    region: &Rect,
    covariance: &Matrix3<f64>,
    pose: Pose2,
) -> f64 {
    let arms = footprint.corners().map(|corner| pose.rotate(corner));
    let angle_rad = gains.sigmas * covariance[(2, 2)].max(0.0).sqrt();
    // What the linear growth leaves out of a turn about `base_link`.
    let bend_m = 0.5 * angle_rad * angle_rad * footprint.radius_m();
    let (sin, cos) = pose.theta_rad.sin_cos();
    let axes = [
        Point2::new(1.0, 0.0),
        Point2::new(0.0, 1.0),
        Point2::new(cos, sin),
        Point2::new(-sin, cos),
    ];
    let mut widest_m = f64::NEG_INFINITY;
    for axis in axes {
        let (low_m, high_m) = region_span_m(region, axis);
        let origin_m = axis.dot(pose.position());
        let (mut least_m, mut most_m) = (f64::INFINITY, f64::NEG_INFINITY);
        for arm in arms {
            let at_m = origin_m + axis.dot(arm);
            let model = Vector3::new(axis.x_m, axis.y_m, arm.cross(axis));
            let growth_m = gains.sigmas * (model.dot(&(covariance * model))).max(0.0).sqrt();
            least_m = least_m.min(at_m - growth_m);
            most_m = most_m.max(at_m + growth_m);
        }
        widest_m = widest_m.max((low_m - most_m).max(least_m - high_m));
    }
    widest_m - gains.fixed_m() - bend_m
}

fn region_span_m(region: &Rect, axis: Point2) -> (f64, f64) {
    let centre_m = axis.dot(region.centre());
    let half = (region.max - region.min) * 0.5;
    let reach_m = half.x_m * axis.x_m.abs() + half.y_m * axis.y_m.abs();
    (centre_m - reach_m, centre_m + reach_m)
}
