//! Guesses at what was meant: near names, and the same name in another unit.

use description::keys::{quoted_list, rounded};

/// Unit endings of keys, longest first where one ends another.
const UNIT_ENDINGS: &[&str] = &[
    "_rad_s2", "_deg_s2", "_rad_s", "_deg_s", "_mm_s2", "_mm_s", "_m_s2", "_m_s", "_km_h", "_1_m2",
    "_1_m", "_1_s", "_degrees", "_radians", "_meters", "_metres", "_meter", "_metre", "_seconds",
    "_inch", "_deg", "_rad", "_mm", "_cm", "_km", "_min", "_sec", "_ms", "_us", "_ns", "_rpm",
    "_hz", "_khz", "_ma", "_mv", "_m", "_s", "_v", "_a",
];

/// What a unit ending means, for people.
const UNIT_NAMES: &[(&str, &str)] = &[
    ("_m", "metres"),
    ("_rad", "radians"),
    ("_s", "seconds"),
    ("_ms", "milliseconds"),
    ("_us", "microseconds"),
    ("_m_s", "metres per second"),
    ("_m_s2", "metres per second squared"),
    ("_rad_s", "radians per second"),
    ("_v", "volts"),
    ("_a", "amperes"),
];

fn split_unit(key: &str) -> (&str, &str) {
    for ending in UNIT_ENDINGS {
        if let Some(stem) = key.strip_suffix(ending) {
            return (stem, ending);
        }
    }
    (key, "")
}

/// The known key that an unknown one probably stands for, and advice.
pub(crate) fn for_key<'a>(unknown: &str, known: &[&'a str]) -> Option<(&'a str, String)> {
    let (stem, ending) = split_unit(unknown);
    let other_unit = known.iter().find(|key| {
        let (known_stem, known_ending) = split_unit(key);
        known_stem == stem && known_ending != ending
    });
    if let Some(key) = other_unit {
        let unit = split_unit(key).1;
        let advice = match UNIT_NAMES.iter().find(|(ending, _)| *ending == unit) {
            Some((_, name)) => format!("did you mean `{key}`? It is in {name}."),
            None => format!("did you mean `{key}`?"),
        };
        return Some((key, advice));
    }
    nearest(unknown, known).map(|key| (key, format!("did you mean `{key}`?")))
}

/// The known name nearest to an unknown one, if any is near enough.
pub(crate) fn nearest<'a>(unknown: &str, known: &[&'a str]) -> Option<&'a str> {
    let allowed = (unknown.chars().count() / 3).clamp(1, 4);
    known
        .iter()
        .map(|name| (distance(unknown, name), *name))
        .filter(|(distance, _)| *distance <= allowed)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}

/// "did you mean" for a name in a value, or the names there are.
pub(crate) fn for_name(unknown: &str, known: &[&str]) -> Option<String> {
    if known.is_empty() {
        return None;
    }
    Some(match nearest(unknown, known) {
        Some(name) => format!("did you mean `{name}`?"),
        None => format!("there are {}", quoted_list(known, "and")),
    })
}

/// Levenshtein distance; long names are cut, a guess needs no more.
fn distance(a: &str, b: &str) -> usize {
    const LONGEST: usize = 64;
    let b: Vec<char> = b.chars().take(LONGEST).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().take(LONGEST).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let substitute = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = substitute.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

/// "250 mm" for a key in metres: the number that should stand there alone.
pub(crate) fn convert_text(text: &str, unit: &str) -> Option<f64> {
    let text = text.trim();
    let split = text
        .char_indices()
        .find(|(_, c)| c.is_alphabetic() || *c == '°')
        .map(|(at, _)| at)?;
    let (number, given) = (
        text[..split].trim().parse::<f64>().ok()?,
        text[split..].trim(),
    );
    let factor = match (given, unit) {
        ("mm", "m") | ("mm/s", "m/s") | ("ms", "s") => 1e-3,
        ("cm", "m") => 1e-2,
        ("km", "m") | ("s", "ms") | ("ms", "µs") => 1e3,
        ("us" | "µs", "s") => 1e-6,
        ("km/h", "m/s") => 1.0 / 3.6,
        ("°" | "deg" | "degrees", "rad") | ("°/s" | "deg/s", "rad/s") => {
            std::f64::consts::PI / 180.0
        }
        ("rpm", "rad/s") => std::f64::consts::PI / 30.0,
        (given, unit) if given == unit => 1.0,
        _ => return None,
    };
    Some(rounded(number * factor))
}
