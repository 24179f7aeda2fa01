//! What a number in a file may be, in words and as a test.

/// A physical quantity: a noun, a unit, and its limits.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    noun: &'static str,
    /// The unit, as it is written behind numbers; empty: none.
    pub unit: &'static str,
    above: Option<f64>,
    at_least: Option<f64>,
    at_most: Option<f64>,
}

impl Quantity {
    /// Any finite number.
    #[must_use]
    pub const fn new(noun: &'static str, unit: &'static str) -> Self {
        Self {
            noun,
            unit,
            above: None,
            at_least: None,
            at_most: None,
        }
    }

    /// More than this.
    #[must_use]
    pub const fn above(mut self, limit: f64) -> Self {
        self.above = Some(limit);
        self
    }

    /// This or more.
    #[must_use]
    pub const fn at_least(mut self, limit: f64) -> Self {
        self.at_least = Some(limit);
        self
    }

    /// This or less.
    #[must_use]
    pub const fn at_most(mut self, limit: f64) -> Self {
        self.at_most = Some(limit);
        self
    }

    /// Whether the value is finite and within the limits.
    #[must_use]
    pub fn holds(&self, value: f64) -> bool {
        value.is_finite()
            && self.above.is_none_or(|limit| value > limit)
            && self.at_least.is_none_or(|limit| value >= limit)
            && self.at_most.is_none_or(|limit| value <= limit)
    }

    /// "a length above 0 and at most 5 m".
    #[must_use]
    pub fn describe(&self) -> String {
        let mut limits = Vec::new();
        if let Some(limit) = self.above {
            limits.push(format!("above {limit}"));
        }
        if let Some(limit) = self.at_least {
            limits.push(format!("at least {}", rounded(limit)));
        }
        if let Some(limit) = self.at_most {
            limits.push(format!("at most {}", rounded(limit)));
        }
        let unit = if self.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", self.unit)
        };
        match limits.is_empty() {
            true if unit.is_empty() => format!("{}, a finite number", self.noun),
            true => format!("{} in{unit}, a finite number", self.noun),
            false => format!("{} {}{unit}", self.noun, limits.join(" and ")),
        }
    }

    /// Advice for a value out of range that fits when read in a smaller unit.
    #[must_use]
    pub fn other_unit(&self, value: f64) -> Option<String> {
        let guesses: &[(&str, f64)] = match self.unit {
            "m" => &[("mm", 1e-3)],
            "m/s" => &[("mm/s", 1e-3)],
            "s" => &[("ms", 1e-3)],
            "rad" => &[("°", std::f64::consts::PI / 180.0)],
            "rad/s" => &[("°/s", std::f64::consts::PI / 180.0)],
            _ => &[],
        };
        guesses
            .iter()
            .find(|(_, factor)| self.holds(value * factor))
            .map(|(unit, factor)| {
                let right = rounded(value * factor);
                format!(
                    "this key is in {}; {value} {unit} is {right} {}",
                    self.unit, self.unit
                )
            })
    }
}

/// A whole number: a noun and its limits.
#[derive(Clone, Copy, Debug)]
pub struct Count {
    noun: &'static str,
    min: i64,
    max: i64,
}

impl Count {
    /// A whole number from `min` to `max`; the limits keep it inside `u32`.
    #[must_use]
    pub const fn new(noun: &'static str, min: u32, max: u32) -> Self {
        Self {
            noun,
            min: min as i64,
            max: max as i64,
        }
    }

    /// Whether the value is within the limits.
    #[must_use]
    pub fn holds(&self, value: i64) -> bool {
        (self.min..=self.max).contains(&value)
    }

    /// "a count, a whole number from 0 to 60".
    #[must_use]
    pub fn describe(&self) -> String {
        format!(
            "{}, a whole number from {} to {}",
            self.noun, self.min, self.max
        )
    }
}

/// A speed of a robot.
pub const SPEED: Quantity = Quantity::new("a speed", "m/s").above(0.0).at_most(3.0);

/// A place in `map`.
pub const POSITION: Quantity = Quantity::new("a position", "m")
    .at_least(-10_000.0)
    .at_most(10_000.0);

/// A short distance to one side.
pub const OFFSET: Quantity = Quantity::new("an offset", "m").at_least(-5.0).at_most(5.0);

/// A direction.
pub const ANGLE: Quantity = Quantity::new("an angle", "rad")
    .at_least(-2.0 * std::f64::consts::PI)
    .at_most(2.0 * std::f64::consts::PI);

/// Six digits behind the point are enough for advice.
#[must_use]
pub fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
