//! Obstacles and walkers that the site file does not know, drawn from the seed.

use serde::Deserialize;

/// What stands and walks on the floor. Lengths in metres of `map`; pairs are the least and the largest value.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clutter {
    /// Boxes stand and people walk in this region: its corners with the least x and y,
    pub min_m: [f64; 2],
    /// and with the largest.
    pub max_m: [f64; 2],
    /// Boxes that stand.
    pub boxes: Boxes,
    /// People who walk about.
    pub people: People,
    /// Vehicles that drive along a line, such as a robot that comes the other way.
    #[serde(default)]
    pub vehicles: Vec<Vehicle>,
}

/// Boxes at random places that always leave a way past them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Boxes {
    /// How many.
    pub count: [u64; 2],
    /// Length of a side.
    pub side_m: [f64; 2],
    /// A way is left along the lane at this y,
    pub lane_y_m: f64,
    /// no farther from it than this,
    pub beside_m: f64,
    /// with this much free floor to either side of the robot's middle.
    pub way_m: f64,
}

/// People who walk from one random place to the next.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct People {
    /// How many.
    pub count: u64,
    /// How large: radius of a disc.
    pub radius_m: [f64; 2],
    /// How fast.
    pub speed_m_s: [f64; 2],
    /// They rest up to this long on their way.
    pub longest_rest_s: f64,
    /// They stop before a robot in their way that is nearer than this; 0: they see nothing.
    pub heed_m: f64,
    /// The same behind a robot, which cannot see them there.
    pub heed_behind_m: f64,
}

/// A vehicle that drives along a line once.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vehicle {
    /// Where it starts.
    pub from_m: [f64; 2],
    /// Where it stops.
    pub to_m: [f64; 2],
    /// Its size.
    pub length_m: f64,
    /// Its size.
    pub width_m: f64,
    /// How fast.
    pub speed_m_s: [f64; 2],
    /// It stops before a robot that is nearer than this.
    pub heed_m: f64,
}

impl Clutter {
    /// What makes no sense, as found and expected.
    pub(super) fn complaints(&self) -> Vec<String> {
        const LARGEST_M: f64 = 100.0;
        const MOST: u64 = 50;
        let mut found = Vec::new();
        let mut pair = |key: &str, [low, high]: [f64; 2], least: f64, most: f64| {
            if !(low >= least && high >= low && high <= most) {
                found.push(format!(
                    "found {key} = [{low}, {high}], expected two ascending numbers from {least} to {most}"
                ));
            }
        };
        for (axis, name) in ["x", "y"].iter().enumerate() {
            let key = format!("min_m and max_m in {name}");
            pair(
                &key,
                [self.min_m[axis], self.max_m[axis]],
                -LARGEST_M,
                LARGEST_M,
            );
        }
        pair("boxes.side_m", self.boxes.side_m, 0.01, 10.0);
        pair("people.radius_m", self.people.radius_m, 0.01, 10.0);
        pair("people.speed_m_s", self.people.speed_m_s, 0.0, 10.0);
        for vehicle in &self.vehicles {
            pair("vehicles.speed_m_s", vehicle.speed_m_s, 0.0, 10.0);
        }
        let way = [self.boxes.beside_m, self.boxes.way_m];
        if !(self.boxes.lane_y_m.abs() <= LARGEST_M
            && way.iter().all(|own| (0.0..=10.0).contains(own)))
        {
            found.push(
                "found a way past the boxes that is off the floor, expected metres of `map`"
                    .to_owned(),
            );
        }
        let [fewest, most] = self.boxes.count;
        if fewest > most || most > MOST || self.people.count > MOST {
            found.push(format!(
                "found {fewest} to {most} boxes and {} people, expected ascending numbers up to {MOST}",
                self.people.count
            ));
        }
        found
    }
}
