//! What kind of robot a robot says it is.

use contract::wire;
use serde::{Deserialize, Serialize};

/// Longer texts are cut off, characters.
const LONGEST: usize = 80;
/// More protocols than any robot knows are left out.
const PROTOCOLS: usize = 8;

/// What kind of robot it is, by its own word. Nothing is granted or refused by it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Factsheet {
    /// Who made it.
    pub manufacturer: String,
    /// What it is.
    pub model: String,
    /// What it runs.
    pub software: String,
    /// How far it reaches from `base_link`: to the front, to the rear, to the left, to the right.
    pub reaches_m: [f64; 4],
    /// Its fastest speed.
    pub max_speed_m_s: f64,
    /// How it brakes before a border.
    pub deceleration_m_s2: f64,
    /// The protocols that it knows, by number; none where it does not say.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub protocols: Vec<u32>,
}

impl Factsheet {
    /// What a report says, as far as it can be.
    pub(crate) fn of(told: &wire::Factsheet) -> Self {
        let text = |text: &str| -> String {
            let plain = text.chars().filter(|character| !character.is_control());
            plain.take(LONGEST).collect()
        };
        let number = |number: f64| if number.is_finite() { number } else { 0.0 };
        Self {
            manufacturer: text(&told.manufacturer),
            model: text(&told.model),
            software: text(&told.software),
            reaches_m: [told.front_m, told.rear_m, told.left_m, told.right_m].map(number),
            max_speed_m_s: number(told.max_speed_m_s),
            deceleration_m_s2: number(told.deceleration_m_s2),
            protocols: told.protocols.iter().copied().take(PROTOCOLS).collect(),
        }
    }

    /// How far its farthest corner is from `base_link`.
    pub(crate) fn reach_m(&self) -> f64 {
        let [front_m, rear_m, left_m, right_m] = self.reaches_m;
        front_m.max(rear_m).hypot(left_m.max(right_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_is_told_is_bounded() {
        let told = wire::Factsheet {
            model: "\u{1b}[2J".to_owned() + &"x".repeat(1 << 16),
            front_m: f64::NAN,
            rear_m: 0.3,
            left_m: 0.4,
            max_speed_m_s: f64::INFINITY,
            protocols: (1..1000).collect(),
            ..wire::Factsheet::default()
        };
        let known = Factsheet::of(&told);
        assert_eq!(known.model.chars().count(), LONGEST);
        assert!(known.model.starts_with("[2Jxx"));
        assert_eq!((known.reaches_m[0], known.max_speed_m_s), (0.0, 0.0));
        assert!((known.reach_m() - 0.5).abs() < 1e-12);
        assert_eq!(known.protocols.len(), PROTOCOLS);
    }
}
