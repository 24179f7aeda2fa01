//! What a number in a file may be, in words and as a test.

/// A physical quantity: a noun, a unit, and its limits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quantity {
    noun: &'static str,
    pub(crate) unit: &'static str,
    above: Option<f64>,
    at_least: Option<f64>,
    at_most: Option<f64>,
}

impl Quantity {
    pub(crate) const fn new(noun: &'static str, unit: &'static str) -> Self {
        Self {
            noun,
            unit,
            above: None,
            at_least: None,
            at_most: None,
        }
    }

    pub(crate) const fn above(mut self, limit: f64) -> Self {
        self.above = Some(limit);
        self
    }

    pub(crate) const fn at_least(mut self, limit: f64) -> Self {
        self.at_least = Some(limit);
        self
    }

    pub(crate) const fn at_most(mut self, limit: f64) -> Self {
        self.at_most = Some(limit);
        self
    }

    /// Whether the value is finite and within the limits.
    pub(crate) fn holds(&self, value: f64) -> bool {
        value.is_finite()
            && self.above.is_none_or(|limit| value > limit)
            && self.at_least.is_none_or(|limit| value >= limit)
            && self.at_most.is_none_or(|limit| value <= limit)
    }

    /// "a length above 0 and at most 5 m".
    pub(crate) fn describe(&self) -> String {
        let mut limits = Vec::new();
        if let Some(limit) = self.above {
            limits.push(format!("above {limit}"));
        }
        if let Some(limit) = self.at_least {
            limits.push(format!("at least {}", crate::hint::rounded(limit)));
        }
        if let Some(limit) = self.at_most {
            limits.push(format!("at most {}", crate::hint::rounded(limit)));
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

    /// What a value out of range would be if it had been meant in a smaller unit.
    pub(crate) fn other_unit(&self, value: f64) -> Option<String> {
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
                let right = crate::hint::rounded(value * factor);
                format!(
                    "this key is in {}; {value} {unit} is {right} {}",
                    self.unit, self.unit
                )
            })
    }
}

/// A whole number: a noun and its limits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Count {
    pub(crate) noun: &'static str,
    pub(crate) min: i64,
    pub(crate) max: i64,
}

impl Count {
    pub(crate) const fn new(noun: &'static str, min: i64, max: i64) -> Self {
        Self { noun, min, max }
    }

    pub(crate) fn describe(&self) -> String {
        format!(
            "{}, a whole number from {} to {}",
            self.noun, self.min, self.max
        )
    }
}

/// A length that is neither zero nor absurd for a robot.
pub(crate) const ROBOT_LENGTH: Quantity = Quantity::new("a length", "m").above(0.0).at_most(5.0);
/// The same, where zero makes sense.
pub(crate) const ROBOT_LENGTH_OR_ZERO: Quantity =
    Quantity::new("a length", "m").at_least(0.0).at_most(5.0);
/// A place in `map`.
pub(crate) const POSITION: Quantity = Quantity::new("a position", "m")
    .at_least(-10_000.0)
    .at_most(10_000.0);
/// An offset in a robot's own frame.
pub(crate) const OFFSET: Quantity = Quantity::new("an offset", "m").at_least(-5.0).at_most(5.0);
/// A direction.
pub(crate) const ANGLE: Quantity = Quantity::new("an angle", "rad")
    .at_least(-2.0 * std::f64::consts::PI)
    .at_most(2.0 * std::f64::consts::PI);
