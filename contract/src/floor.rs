//! The floor that both sides must know alike: areas, how many robots each holds, and where it is.

use std::fmt::Write as _;

use description::site::Area;

use crate::wire;

/// An area of the floor.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorArea {
    /// Its semantic id.
    pub id: String,
    /// How many robots it holds.
    pub capacity: u32,
    /// The corner with the smallest coordinates in `map`, metres.
    pub min_m: [f64; 2],
    /// That with the largest.
    pub max_m: [f64; 2],
}

/// All areas, in the order of their ids, and their hash.
#[derive(Clone, Debug, PartialEq)]
pub struct Floor {
    areas: Vec<FloorArea>,
    hash: u64,
}

impl Floor {
    /// Of areas in any order.
    #[must_use]
    pub fn new(mut areas: Vec<FloorArea>) -> Self {
        areas.sort_by(|one, other| one.id.cmp(&other.id));
        let mut text = String::new();
        areas.iter().for_each(|area| area.write(&mut text));
        let hash = fnv_1a(text.as_bytes());
        Self { areas, hash }
    }

    /// Of a site file's areas.
    #[must_use]
    pub fn of(areas: &[Area]) -> Self {
        let area = |area: &Area| FloorArea {
            id: area.id.clone(),
            capacity: area.capacity,
            min_m: area.region.min.xy_m(),
            max_m: area.region.max.xy_m(),
        };
        Self::new(areas.iter().map(area).collect())
    }

    /// What a message says of one.
    #[must_use]
    pub fn said(areas: &[wire::FloorArea]) -> Self {
        let area = |area: &wire::FloorArea| FloorArea {
            id: area.id.clone(),
            capacity: area.capacity,
            min_m: [area.min_x_m, area.min_y_m],
            max_m: [area.max_x_m, area.max_y_m],
        };
        Self::new(areas.iter().map(area).collect())
    }

    /// For a message.
    #[must_use]
    pub fn say(&self) -> Vec<wire::FloorArea> {
        let area = |area: &FloorArea| wire::FloorArea {
            id: area.id.clone(),
            capacity: area.capacity,
            min_x_m: area.min_m[0],
            min_y_m: area.min_m[1],
            max_x_m: area.max_m[0],
            max_y_m: area.max_m[1],
        };
        self.areas.iter().map(area).collect()
    }

    /// FNV-1a with 64 bits (Fowler, Noll, Vo) over a line for each area, in the order of ids: id, capacity, least x, least y, largest
    /// x, largest y, the coordinates in whole millimetres, with a tab between them and a line feed at the end.
    #[must_use]
    pub fn hash(&self) -> u64 {
        self.hash
    }

    /// What the other side, which says this hash and these areas, knows otherwise: the first area that differs.
    #[must_use]
    pub fn differs(&self, hash: u64, areas: &[wire::FloorArea]) -> Option<String> {
        if hash == self.hash {
            return None;
        }
        let theirs = Self::said(areas);
        let known = { self.difference(&theirs) }.filter(|_| theirs.hash == hash);
        Some(known.unwrap_or_else(|| "it has not said what differs".to_owned()))
    }

    fn difference(&self, theirs: &Self) -> Option<String> {
        if self.hash == theirs.hash {
            return None;
        }
        let lacks = |id: &str, areas: &[FloorArea]| !areas.iter().any(|area| area.id == id);
        for own in &self.areas {
            let Some(other) = theirs.areas.iter().find(|area| area.id == own.id) else {
                return Some(format!("area `{}` is unknown to it", own.id));
            };
            if own.lines() != other.lines() {
                let (own_says, other_says) = (own.describe(), other.describe());
                return Some(format!(
                    "area `{}` {other_says} by its site file, and {own_says} by ours",
                    own.id
                ));
            }
        }
        let more = { theirs.areas.iter() }.find(|area| lacks(&area.id, &self.areas));
        more.map(|area| {
            format!(
                "it knows an area `{}`, which our site does not have",
                area.id
            )
        })
    }
}

/// No areas at all.
impl Default for Floor {
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

impl FloorArea {
    fn corners_mm(&self) -> [i64; 4] {
        let [min, max] = [self.min_m, self.max_m];
        [min[0], min[1], max[0], max[1]].map(|at_m| (at_m * 1e3).round() as i64)
    }

    fn lines(&self) -> String {
        let mut text = String::new();
        self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) {
        let [left, bottom, right, top] = self.corners_mm();
        // Text takes everything.
        let _ = writeln!(
            text,
            "{}\t{}\t{left}\t{bottom}\t{right}\t{top}",
            self.id, self.capacity
        );
    }

    fn describe(&self) -> String {
        let [[left, bottom], [right, top]] = [self.min_m, self.max_m];
        format!(
            "holds {} and goes from ({left:.3}, {bottom:.3}) to ({right:.3}, {top:.3}) m",
            self.capacity
        )
    }
}

fn fnv_1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(id: &str, capacity: u32, max_x_m: f64) -> FloorArea {
        FloorArea {
            id: id.into(),
            capacity,
            min_m: [-0.5, 0.0],
            max_m: [max_x_m, 2.25],
        }
    }

    #[test]
    fn the_hash_is_that_of_the_text() {
        // The published test value of "a".
        assert_eq!(fnv_1a(b"a"), 0xaf63_dc4c_8601_ec8c);
        let floor = Floor::new(vec![area("gate", 1, 4.0), area("bay", 2, 3.0)]);
        let text = "bay\t2\t-500\t0\t3000\t2250\ngate\t1\t-500\t0\t4000\t2250\n";
        assert_eq!(floor.hash(), fnv_1a(text.as_bytes()));
        assert_eq!(Floor::said(&floor.say()), floor);
        assert_eq!(Floor::default().hash(), fnv_1a(b""));
    }

    #[test]
    fn what_differs_is_named() {
        let ours = Floor::new(vec![area("gate", 1, 4.0), area("bay", 2, 3.0)]);
        let differs = |areas: Vec<FloorArea>| ours.difference(&Floor::new(areas));
        let [gate, bay] = [area("gate", 1, 4.0), area("bay", 2, 3.0)];
        assert_eq!(differs(vec![bay.clone(), gate.clone()]), None);
        // Less than half a millimetre is none.
        assert_eq!(differs(vec![bay.clone(), area("gate", 1, 4.0004)]), None);
        for (areas, expected) in [
            (vec![gate.clone()], "area `bay` is unknown to it"),
            (
                vec![area("bay", 3, 3.0), gate.clone()],
                "area `bay` holds 3 and goes from (-0.500, 0.000) to (3.000, 2.250) m by its site file, and holds 2 and",
            ),
            (
                vec![bay.clone(), area("gate", 1, 4.5)],
                "area `gate` holds 1 and goes from (-0.500, 0.000) to (4.500, 2.250) m by its site file",
            ),
            (
                vec![bay, gate, area("yard", 1, 1.0)],
                "it knows an area `yard`, which our site does not have",
            ),
        ] {
            let found = differs(areas).expect("they differ");
            assert!(found.starts_with(expected), "{found}");
        }
    }
}
