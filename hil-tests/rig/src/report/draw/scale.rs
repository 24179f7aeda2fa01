//! Round numbers for axes, and colours.

/// Steps of an axis: 1, 2 or 5 times a power of ten, no more than `most` of them.
pub(in crate::report) fn step(range: f64, most: f64) -> f64 {
    let least = (range / most.max(1.0)).clamp(1e-6, 1e12);
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|digit| digit * power)
        .find(|step| *step >= least * 0.999_999)
        .unwrap_or(10.0 * power)
}

/// The multiples of a step within a range; never more than a hundred.
pub(in crate::report) fn ticks(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let slack = step * 1e-6;
    let first = ((low - slack) / step).ceil();
    (0..100)
        .map(move |index| (first + f64::from(index)) * step)
        .take_while(move |tick| *tick <= high + slack)
}

/// A number as an axis shows it: with the digits that the step has.
pub(in crate::report) fn label(tick: f64, step: f64) -> String {
    let digits = (-(step.log10() + 1e-9).floor()).clamp(0.0, 6.0) as usize;
    // Adding 0 turns -0 into 0.
    format!("{:.digits$}", tick + 0.0).replace('-', "−")
}

/// Colour of a speed, given as a share of the fastest: dark when slow, bright when fast, never red.
pub(in crate::report) fn speed_colour(share: f64) -> String {
    const COLOURS: [[f64; 3]; 5] = [
        [76.0, 10.0, 96.0],
        [64.0, 82.0, 160.0],
        [33.0, 140.0, 152.0],
        [52.0, 182.0, 110.0],
        [146.0, 214.0, 44.0],
    ];
    let place = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let index = (place as usize).min(COLOURS.len() - 2);
    let part = place - index as f64;
    let [red, green, blue] = [0, 1, 2].map(|channel| {
        let (low, high) = (COLOURS[index][channel], COLOURS[index + 1][channel]);
        (low + (high - low) * part).round() as u8
    });
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Light colour of an area, by its index.
pub(in crate::report) fn area_colour(index: usize) -> &'static str {
    const COLOURS: [&str; 8] = [
        "#dbeafe", "#dcfce7", "#fef3c7", "#ede9fe", "#e0f2fe", "#fae8ff", "#ecfccb", "#ffedd5",
    ];
    COLOURS[index % COLOURS.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_round_steps() {
        assert_eq!(
            [step(10.0, 12.0), step(0.45, 5.0), step(163.0, 16.0)],
            [1.0, 0.1, 20.0]
        );
        let labels: Vec<String> = ticks(-0.12, 0.12, 0.1)
            .map(|tick| label(tick, 0.1))
            .collect();
        assert_eq!(labels, ["−0.1", "0.0", "0.1"]);
        assert_eq!(ticks(0.0, 1e9, 1.0).count(), 100);
        assert_eq!(label(20.0, 20.0), "20");
        assert_eq!(label(0.05, 0.05), "0.05");
    }

    #[test]
    fn colours_end_where_the_speeds_end() {
        assert_eq!(
            [speed_colour(-1.0), speed_colour(f64::NAN.max(0.0))],
            ["#4c0a60", "#4c0a60"]
        );
        assert_eq!(
            [speed_colour(1.0), speed_colour(7.0)],
            ["#92d62c", "#92d62c"]
        );
    }
}
