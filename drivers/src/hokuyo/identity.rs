//! What the device says about itself (SCIP 2.0, commands `VV`, `PP` and `II`).

use std::f64::consts::TAU;
use std::time::Duration;

use super::error::ConnectError;

/// Vendor, product and versions: the reply to `VV`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SensorIdentity {
    /// Vendor.
    pub vendor: String,
    /// Product.
    pub product: String,
    /// Firmware version.
    pub firmware: String,
    /// Protocol version.
    pub protocol: String,
    /// Serial number.
    pub serial: String,
}

/// What it measures: the reply to `PP`, under the names of the protocol.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameters {
    /// Model.
    pub model: String,
    /// Shortest length.
    pub dmin_mm: u32,
    /// Longest length.
    pub dmax_mm: u32,
    /// Steps per turn.
    pub ares: u16,
    /// First step that is measured.
    pub amin: u16,
    /// Last step that is measured.
    pub amax: u16,
    /// The step that looks to the front.
    pub afrt: u16,
    /// Turns per minute.
    pub scan_rpm: u16,
}

/// The device's state: the reply to `II`, in the device's words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceState {
    /// `LASR`: the laser, on or off.
    pub laser: String,
    /// `SCSP`: the speed of the motor.
    pub speed: String,
    /// `MESM`: the measuring mode.
    pub mode: String,
    /// `SBPS`: the bit rate, or that it is USB.
    pub bit_rate: String,
    /// `STAT`: whether it works well.
    pub status: String,
}

impl DeviceState {
    /// Whether it says that it works well; so does a firmware that says nothing.
    #[must_use]
    pub fn is_well(&self) -> bool {
        self.status.is_empty() || self.status.to_ascii_lowercase().contains("works well")
    }
}

impl Parameters {
    /// The parameters of the URG-04LX.
    #[must_use]
    pub fn urg_04lx() -> Self {
        Self {
            model: "URG-04LX(Hokuyo Automatic Co., Ltd.)".into(),
            dmin_mm: 20,
            dmax_mm: 5600,
            ares: 1024,
            amin: 44,
            amax: 725,
            afrt: 384,
            scan_rpm: 600,
        }
    }

    /// What is different from the URG-04LX for whoever uses its scans, for people: steps, turns.
    ///
    /// # Errors
    /// A sentence.
    pub fn check_urg_04lx(&self) -> Result<(), String> {
        let steps = |own: &Self| (own.amin, own.amax, own.ares, own.afrt, own.scan_rpm);
        let told = |own: &Self| {
            let (first, last, turn, front, rpm) = steps(own);
            format!(
                "steps {first} to {last} of {turn} in a turn, step {front} to the front, {rpm} turns in a minute"
            )
        };
        let supported = Self::urg_04lx();
        if steps(self) == steps(&supported) {
            return Ok(());
        }
        Err(format!(
            "the device {:?} is not supported: found {}; expected those of the URG-04LX, {}",
            self.model,
            told(self),
            told(&supported)
        ))
    }

    /// The angle of a step in the sensor's frame: 0 to the front, positive to the left.
    #[must_use]
    pub fn step_angle_rad(&self, step: u16) -> f64 {
        (f64::from(step) - f64::from(self.afrt)) * self.step_rad()
    }

    /// The angle between two steps.
    #[must_use]
    pub fn step_rad(&self) -> f64 {
        TAU / f64::from(self.ares)
    }

    /// Turns per second.
    #[must_use]
    pub fn scan_hz(&self) -> f64 {
        f64::from(self.scan_rpm) / 60.0
    }

    /// The time of one turn.
    #[must_use]
    pub fn turn(&self) -> Duration {
        Duration::from_nanos(60_000_000_000 / u64::from(self.scan_rpm.max(1)))
    }

    /// The time from the start of a turn until it reaches `step`.
    #[must_use]
    pub fn step_time(&self, step: u16) -> Duration {
        self.turn() * u32::from(step) / u32::from(self.ares.max(1))
    }
}

/// The fields of a reply, their checksums verified.
pub struct Fields {
    /// The command they answer.
    pub command: &'static str,
    /// Keys and values.
    pub fields: Vec<(String, String)>,
}

impl Fields {
    fn find(&self, key: &str) -> Option<&str> {
        self.fields
            .iter()
            .find(|(name, _)| name == key)
            .map(|(_, value)| value.trim())
    }

    fn text(&self, field: &'static str) -> Result<String, ConnectError> {
        self.find(field)
            .map(Into::into)
            .ok_or_else(|| self.wrong(field, "text", ""))
    }

    fn number<T: TryFrom<u32>>(
        &self,
        field: &'static str,
        expected: &'static str,
        fits: impl Fn(u32) -> bool,
    ) -> Result<T, ConnectError> {
        let found = self.find(field).unwrap_or_default();
        let number = found.parse().ok().filter(|number| fits(*number));
        number
            .and_then(|number| T::try_from(number).ok())
            .ok_or_else(|| self.wrong(field, expected, found))
    }

    fn wrong(&self, field: &'static str, expected: &'static str, found: &str) -> ConnectError {
        ConnectError::Field {
            command: self.command,
            field,
            expected,
            found: found.into(),
        }
    }

    /// Reads a `VV` reply.
    pub fn identity(&self) -> Result<SensorIdentity, ConnectError> {
        Ok(SensorIdentity {
            vendor: self.text("VEND")?,
            product: self.text("PROD")?,
            firmware: self.text("FIRM")?,
            protocol: self.text("PROT")?,
            serial: self.text("SERI")?,
        })
    }

    /// Reads a `PP` reply.
    pub fn parameters(&self) -> Result<Parameters, ConnectError> {
        let ares: u16 = self.number("ARES", "steps per turn, 1 to 9999", |n| {
            (1..=9999).contains(&n)
        })?;
        let amax: u16 = self.number("AMAX", "a step below ARES", |n| n < u32::from(ares))?;
        Ok(Parameters {
            model: self.text("MODL")?,
            dmin_mm: self.number("DMIN", "a length in mm", |_| true)?,
            dmax_mm: self.number("DMAX", "a length in mm", |n| n > 0)?,
            ares,
            amin: self.number("AMIN", "a step up to AMAX", |n| n <= u32::from(amax))?,
            amax,
            afrt: self.number("AFRT", "a step below ARES", |n| n < u32::from(ares))?,
            scan_rpm: self.number("SCAN", "turns per minute, 1 to 60000", |n| {
                (1..=60_000).contains(&n)
            })?,
        })
    }

    /// Reads an `II` reply. Firmware differs in what it says here, so nothing is required.
    pub fn state(&self) -> DeviceState {
        let text = |key| self.find(key).unwrap_or_default().into();
        DeviceState {
            laser: text("LASR"),
            speed: text("SCSP"),
            mode: text("MESM"),
            bit_rate: text("SBPS"),
            status: text("STAT"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_urg_04lx_is_one() {
        let own = Parameters::urg_04lx();
        assert_eq!(own.check_urg_04lx(), Ok(()));
        // A turn of finer steps, of which it measures as many.
        let ares = 1440;
        let told = Parameters { ares, ..own }.check_urg_04lx().unwrap_err();
        assert!(
            told.contains("of 1440 in a turn") && told.contains("URG-04LX"),
            "{told}"
        );
    }

    #[test]
    fn works_well_only_when_it_says_so() {
        let says = |status: &str| {
            let fields = vec![("STAT".to_owned(), status.to_owned())];
            let command = "II";
            Fields { command, fields }.state().is_well()
        };
        assert!(says("Sensor works well.") && says(""));
        assert!(!says("Sensor malfunction") && !says("Motor error"));
    }

    fn pp(replace: &str, value: &str) -> Fields {
        let fields = [
            ("MODL", "URG-04LX(Hokuyo Automatic Co., Ltd.)"),
            ("DMIN", "20"),
            ("DMAX", "5600"),
            ("ARES", "1024"),
            ("AMIN", "44"),
            ("AMAX", "725"),
            ("AFRT", "384"),
            ("SCAN", "600"),
        ];
        let fields = fields.map(|(key, original)| {
            (
                key.to_owned(),
                if key == replace { value } else { original }.to_owned(),
            )
        });
        Fields {
            command: "PP",
            fields: fields.into(),
        }
    }

    #[test]
    fn reads_the_parameters_of_the_urg_04lx() {
        let parameters = pp("", "").parameters().unwrap();
        assert_eq!(parameters, Parameters::urg_04lx());
        assert_eq!(parameters.turn(), Duration::from_millis(100));
        assert_eq!(parameters.step_angle_rad(384), 0.0);
        assert!((parameters.step_angle_rad(725).to_degrees() - 119.88).abs() < 0.01);
        assert_eq!(parameters.step_time(512), Duration::from_millis(50));
    }

    #[test]
    fn refuses_parameters_that_make_no_sense() {
        for (field, value) in [
            ("ARES", "0"),
            ("ARES", "70000"),
            ("AMAX", "1024"),
            ("AMIN", "726"),
            ("AFRT", "-1"),
            ("SCAN", "0"),
            ("DMAX", "x"),
            ("DMIN", ""),
        ] {
            let error = pp(field, value).parameters().unwrap_err().to_string();
            assert!(error.contains(field) && error.contains("PP"), "{error}");
        }
    }
}
