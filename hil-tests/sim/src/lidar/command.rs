//! From a line of bytes to a command, or to the status that refuses it.

/// Two characters that end a reply.
pub(super) type Status = [u8; 2];

pub(super) const OK: Status = *b"00";
pub(super) const TOO_FEW_PARAMETERS: Status = *b"0C";
pub(super) const TOO_MANY_CHARACTERS: Status = *b"0D";
pub(super) const UNDEFINED: Status = *b"0E";
pub(super) const STRING_TOO_LONG: Status = *b"0G";
pub(super) const STRING_INVALID: Status = *b"0H";

const MAX_STRING: usize = 16;
/// The last step that may be asked for.
const MAX_STEP: u32 = 768;

/// Steps and cluster of a measurement, and how its values are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Section {
    pub(super) first_step: usize,
    pub(super) last_step: usize,
    pub(super) cluster: usize,
    pub(super) characters: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ScipCommand {
    Version,
    Parameters,
    State,
    /// `%ST`: what it is doing, in three digits.
    Activity,
    LaserOn,
    Quit,
    Reset,
    /// The control code, which the device judges.
    Time(u8),
    /// Six characters, or what is not a number.
    BitRate(Option<u32>),
    /// Two characters, or what is not a number.
    MotorSpeed(Option<u32>),
    Get(Section),
    Stream {
        section: Section,
        skip: u32,
        /// 0: until stopped.
        count: u32,
    },
}

/// Reads a SCIP 2.0 command; the terminator is already gone.
pub(super) fn parse(line: &[u8]) -> Result<ScipCommand, Status> {
    if let Some(rest) = line.strip_prefix(b"%ST") {
        return check_string(rest).map(|()| ScipCommand::Activity);
    }
    let symbol = line.get(..2).ok_or(UNDEFINED)?;
    let length = match symbol {
        b"VV" | b"PP" | b"II" | b"BM" | b"QT" | b"RS" => 0,
        b"TM" => 1,
        b"CR" => 2,
        b"SS" => 6,
        b"GD" | b"GS" => 10,
        b"MD" | b"MS" => 13,
        _ => return Err(UNDEFINED),
    };
    let rest = &line[2..];
    let parameters = rest.get(..length).ok_or(TOO_FEW_PARAMETERS)?;
    check_string(&rest[length..])?;
    let characters = if symbol[1] == b'S' { 2 } else { 3 };
    Ok(match symbol {
        b"VV" => ScipCommand::Version,
        b"PP" => ScipCommand::Parameters,
        b"II" => ScipCommand::State,
        b"BM" => ScipCommand::LaserOn,
        b"QT" => ScipCommand::Quit,
        b"RS" => ScipCommand::Reset,
        b"TM" => ScipCommand::Time(parameters[0]),
        b"CR" => ScipCommand::MotorSpeed(number(parameters)),
        b"SS" => ScipCommand::BitRate(number(parameters)),
        b"GD" | b"GS" => ScipCommand::Get(section(parameters, characters)?),
        _ => ScipCommand::Stream {
            section: section(parameters, characters)?,
            skip: number(&parameters[10..11]).ok_or(*b"06")?,
            count: number(&parameters[11..13]).ok_or(*b"07")?,
        },
    })
}

/// Reads start, end and cluster, four, four and two digits, or three, three and two as in SCIP 1.1.
pub(super) fn section(parameters: &[u8], characters: u32) -> Result<Section, Status> {
    let digits = if parameters.len() < 10 { 3 } else { 4 };
    let field = |from: usize, to: usize| parameters.get(from..to).and_then(number);
    let first = field(0, digits).ok_or(*b"01")?;
    let last = field(digits, 2 * digits).ok_or(*b"02")?;
    let cluster = field(2 * digits, 2 * digits + 2).ok_or(*b"03")?;
    if last > MAX_STEP {
        return Err(*b"04");
    }
    if last < first {
        return Err(*b"05");
    }
    Ok(Section {
        first_step: first as usize,
        last_step: last as usize,
        cluster: cluster.max(1) as usize,
        characters,
    })
}

/// The user's string after the parameters, set off by a semicolon.
fn check_string(rest: &[u8]) -> Result<(), Status> {
    let string = match rest {
        [] => return Ok(()),
        [b';', string @ ..] => string,
        _ => return Err(TOO_MANY_CHARACTERS),
    };
    if string.len() > MAX_STRING {
        return Err(STRING_TOO_LONG);
    }
    if string.iter().any(|byte| !(b' '..=b'~').contains(byte)) {
        return Err(STRING_INVALID);
    }
    Ok(())
}

/// A number in decimal digits alone.
pub(super) fn number(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0u32, |value, digit| {
        let digit = digit.is_ascii_digit().then(|| u32::from(digit - b'0'))?;
        value.checked_mul(10)?.checked_add(digit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_refusal_has_its_status() {
        for (line, status) in [
            (&b"X"[..], b"0E"),
            (b"XX", b"0E"),
            (b"SCIP2.0", b"0E"),
            (b"MD0044", b"0C"),
            (b"TM", b"0C"),
            (b"VVabc", b"0D"),
            (b"QTx", b"0D"),
            (b"MD0044072501000x", b"0D"),
            (b"VV;12345678901234567", b"0G"),
            (b"VV;ab\x01", b"0H"),
            (b"MDx044072501000", b"01"),
            (b"MD0044x72501000", b"02"),
            (b"MD00440725x1000", b"03"),
            (b"MD0044076901000", b"04"),
            (b"MD0700004401000", b"05"),
            (b"MD0044072501x00", b"06"),
            (b"MD00440725010x0", b"07"),
        ] {
            assert_eq!(parse(line), Err(*status), "{}", line.escape_ascii());
        }
    }

    #[test]
    fn a_stream_is_read_in_full() {
        let expected = ScipCommand::Stream {
            section: Section {
                first_step: 44,
                last_step: 725,
                cluster: 2,
                characters: 2,
            },
            skip: 3,
            count: 5,
        };
        assert_eq!(parse(b"MS0044072502305;hello"), Ok(expected));
        assert_eq!(parse(b"SSabcdef"), Ok(ScipCommand::BitRate(None)));
    }
}
