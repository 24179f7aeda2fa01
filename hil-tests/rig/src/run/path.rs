//! Where a robot truly was, for as long as a run may take.

use crate::record::PathPoint;

/// So many points are kept: every look of an hour, and some.
const MOST: usize = 200_000;

/// A path whose memory is bounded: of a run that takes longer than an hour a point stands for two looks, then for four.
#[derive(Clone, Debug)]
pub struct Path {
    points: Vec<PathPoint>,
    most: usize,
    /// How many looks one point stands for,
    looks: u32,
    /// and how many the last one does.
    looked: u32,
}

impl Default for Path {
    fn default() -> Self {
        Self::of_at_most(MOST)
    }
}

impl Path {
    fn of_at_most(most: usize) -> Self {
        Self {
            points: Vec::new(),
            most,
            looks: 1,
            looked: 1,
        }
    }

    /// The next look.
    pub(super) fn push(&mut self, point: PathPoint) {
        if self.looked < self.looks
            && let Some(last) = self.points.last_mut()
        {
            *last = merged(*last, point);
            self.looked += 1;
            return;
        }
        if self.points.len() >= self.most {
            let pairs = self.points.chunks(2);
            let merged = pairs.map(|pair| pair.iter().copied().reduce(merged).unwrap_or(pair[0]));
            self.points = merged.collect();
            self.looks *= 2;
        }
        self.points.push(point);
        self.looked = 1;
    }

    /// In order of time, all with the same number of looks to them but the last.
    #[must_use]
    pub fn points(&self) -> &[PathPoint] {
        &self.points
    }
}

/// Two in one: where it was first, and the worst of what happened.
fn merged(first: PathPoint, second: PathPoint) -> PathPoint {
    PathPoint {
        clearance_m: first.clearance_m.min(second.clearance_m),
        in_contact: first.in_contact || second.in_contact,
        ..first
    }
}

#[cfg(test)]
mod tests {
    use sim::world::Pose;

    use super::*;

    #[test]
    fn a_long_path_keeps_its_beginning_its_end_and_every_contact() {
        let mut path = Path::of_at_most(100);
        for look in 0..1_000 {
            path.push(PathPoint {
                at_s: f64::from(look),
                pose: Pose::new(f64::from(look), 0.0, 0.0),
                speed_m_s: 0.4,
                clearance_m: if look == 501 { 0.1 } else { 1.0 },
                in_contact: look == 777,
            });
            let points = path.points();
            assert!(points.len() <= 100);
            let behind = f64::from(look) - points[points.len() - 1].at_s;
            assert!(behind < 16.0, "{look}: {behind} looks behind");
        }
        let points = path.points();
        assert!(points.len() > 50 && points[0].at_s == 0.0);
        let gaps = points.windows(2).map(|pair| pair[1].at_s - pair[0].at_s);
        assert!(gaps.clone().all(|gap| gap == 16.0), "{points:?}");
        let contacts: Vec<f64> = { points.iter().filter(|point| point.in_contact) }
            .map(|point| point.at_s)
            .collect();
        assert_eq!(contacts, [768.0]);
        let near = points.iter().filter(|point| point.clearance_m < 0.5);
        assert_eq!(near.count(), 1);
    }

    #[test]
    fn nothing_is_left_out_of_a_short_one() {
        let mut path = Path::of_at_most(100);
        for look in 0..100 {
            path.push(PathPoint {
                at_s: f64::from(look),
                pose: Pose::default(),
                speed_m_s: 0.0,
                clearance_m: 1.0,
                in_contact: false,
            });
        }
        assert_eq!(path.points().len(), 100);
    }
}
