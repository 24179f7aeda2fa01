//! The texts of VV, PP and II.

use super::codec::report_line;

/// What II tells of the device's state.
pub(super) struct State {
    pub(super) laser: bool,
    pub(super) streaming: bool,
    pub(super) rpm: u32,
    pub(super) speed_level: u32,
    pub(super) bit_rate: u32,
    pub(super) bit_rate_changed: bool,
    pub(super) device_ms: u32,
    pub(super) unwell: bool,
}

/// What a device says of itself that works well, and one whose laser does not.
const WELL: &str = "Sensor works well.";
const UNWELL: &str = "Laser malfunction.";

const MODEL: &str = "URG-04LX(Hokuyo Automatic Co.,Ltd.)";

/// What VV answers in SCIP 2.0 and V in 1.1.
pub(super) fn version_lines(serial: &str, protocol: &str) -> [String; 5] {
    [
        "VEND:Hokuyo Automatic Co.,Ltd.".to_owned(),
        "PROD:SOKUIKI Sensor URG-04LX".to_owned(),
        "FIRM:3.1.04(simulated)".to_owned(),
        format!("PROT:{protocol}"),
        format!("SERI:{serial}"),
    ]
}

pub(super) fn version(serial: &str, out: &mut Vec<u8>) {
    for line in version_lines(serial, "SCIP 2.0") {
        report_line(&line, out);
    }
}

pub(super) fn parameters(out: &mut Vec<u8>) {
    report_line(&format!("MODL:{MODEL}"), out);
    for line in [
        "DMIN:20",
        "DMAX:5600",
        "ARES:1024",
        "AMIN:44",
        "AMAX:725",
        "AFRT:384",
        "SCAN:600",
    ] {
        report_line(line, out);
    }
}

pub(super) fn state(state: &State, out: &mut Vec<u8>) {
    const DEFAULT: &str = "Default setting by user";
    const CHANGED: &str = "Changed by communication";
    let speed = match state.speed_level {
        0 => format!("SCSP:Initial({}[rpm])<-{DEFAULT}", state.rpm),
        level => format!("SCSP:{level:02}({}[rpm])<-{CHANGED}", state.rpm),
    };
    let bit_rate_from = if state.bit_rate_changed {
        CHANGED
    } else {
        DEFAULT
    };
    for line in [
        format!("MODL:{MODEL}"),
        format!("LASR:{}", if state.laser { "ON" } else { "OFF" }),
        speed,
        format!(
            "MESM:{}",
            if state.streaming { "Measuring" } else { "IDLE" }
        ),
        format!("SBPS:{}[bps]<-{bit_rate_from}", state.bit_rate),
        format!("TIME:{:06X}", state.device_ms),
        format!("STAT:{}", if state.unwell { UNWELL } else { WELL }),
    ] {
        report_line(&line, out);
    }
}
