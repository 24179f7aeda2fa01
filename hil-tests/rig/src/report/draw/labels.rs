//! Where a label can stand without covering anything.

use super::canvas::Px2;
use super::thin::distance_px;

/// Size of the text in labels.
pub(in crate::report) const LABEL_PX: f64 = 13.0;
/// Height of a label.
pub(in crate::report) const PILL_HEIGHT_PX: f64 = 20.0;

/// About the width of a text, rather too much than too little.
pub(in crate::report) fn text_width_px(text: &str, size_px: f64) -> f64 {
    let ems = text
        .chars()
        .map(|character| if character < '\u{2e80}' { 0.6 } else { 1.05 });
    ems.sum::<f64>() * size_px
}

/// A rectangle on the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::report) struct Field {
    /// Upper left corner.
    pub(in crate::report) min: Px2,
    /// Lower right corner.
    pub(in crate::report) max: Px2,
}

impl Field {
    pub(in crate::report) fn around(centre: Px2, size: Px2) -> Self {
        Self {
            min: [centre[0] - size[0] / 2.0, centre[1] - size[1] / 2.0],
            max: [centre[0] + size[0] / 2.0, centre[1] + size[1] / 2.0],
        }
    }

    /// The least that holds these points.
    pub(in crate::report) fn over(points: &[Px2]) -> Self {
        let bound = |none: f64, better: fn(f64, f64) -> f64| {
            [0, 1].map(|axis| points.iter().map(|at| at[axis]).fold(none, better))
        };
        Self {
            min: bound(f64::INFINITY, f64::min),
            max: bound(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Left, top, width and height.
    pub(in crate::report) fn rectangle(&self) -> [f64; 4] {
        let [width, height] = [0, 1].map(|axis| self.max[axis] - self.min[axis]);
        [self.min[0], self.min[1], width, height]
    }

    pub(in crate::report) fn middle(&self) -> Px2 {
        [0, 1].map(|axis| (self.min[axis] + self.max[axis]) / 2.0)
    }

    pub(in crate::report) fn contains(&self, at: Px2) -> bool {
        (0..2).all(|axis| at[axis] >= self.min[axis] && at[axis] <= self.max[axis])
    }

    /// The point of it nearest to `at`.
    pub(in crate::report) fn nearest(&self, at: Px2) -> Px2 {
        [0, 1].map(|axis| at[axis].clamp(self.min[axis], self.max[axis]))
    }

    fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.min[axis] < other.max[axis] && other.min[axis] < self.max[axis])
    }

    fn holds(&self, other: &Self) -> bool {
        self.contains(other.min) && self.contains(other.max)
    }
}

/// What is taken on the map.
#[derive(Debug)]
pub(in crate::report) struct Labels {
    frame: Field,
    taken: Vec<Field>,
    // Points of the drawing that labels should not cover, but may.
    avoid: Vec<Px2>,
}

impl Labels {
    pub(in crate::report) fn new(frame: Field) -> Self {
        Self {
            frame,
            taken: Vec::new(),
            avoid: Vec::new(),
        }
    }

    /// Nothing may cover this.
    pub(in crate::report) fn take(&mut self, field: Field) {
        self.taken.push(field);
    }

    /// Labels rather stand elsewhere.
    pub(in crate::report) fn avoid(&mut self, points: impl IntoIterator<Item = Px2>) {
        self.avoid.extend(points);
    }

    /// Labels rather do not cover a line.
    pub(in crate::report) fn avoid_line(&mut self, from: Px2, to: Px2) {
        const STEP_PX: f64 = 8.0;
        let steps = (distance_px(from, to) / STEP_PX).ceil().clamp(1.0, 500.0) as u32;
        self.avoid((0..=steps).map(|step| between(from, to, f64::from(step) / f64::from(steps))));
    }

    /// Takes the best free place beside what is named; `None` when there is none.
    pub(in crate::report) fn place(&mut self, named: &Field, size: Px2) -> Option<Field> {
        const DISTANCES_PX: [f64; 6] = [7.0, 18.0, 32.0, 48.0, 68.0, 92.0];
        const STEPS: [f64; 5] = [0.0, -0.5, 0.5, -1.0, 1.0];
        // Of the square around the anchor, from its middles to its corners.
        let directions = STEPS
            .iter()
            .flat_map(|&step| [[step, -1.0], [step, 1.0], [1.0, step], [-1.0, step]]);
        let anchor = named.middle();
        // What is off the map needs no name; it may even be at infinity.
        if !self.frame.contains(anchor) {
            return None;
        }
        let mut best: Option<(f64, Field)> = None;
        for (distance_px, direction) in DISTANCES_PX.iter().flat_map(|distance_px| {
            directions
                .clone()
                .map(move |direction| (distance_px, direction))
        }) {
            let centre = [0, 1].map(|axis| {
                let half_px = (size[axis] + named.max[axis] - named.min[axis]) / 2.0;
                anchor[axis] + direction[axis] * (distance_px + half_px)
            });
            let field = Field::around(centre, size);
            if best.is_some_and(|(cost, _)| cost <= *distance_px) || !self.is_free(anchor, &field) {
                continue;
            }
            let covered = self.avoid.iter().filter(|&&at| field.contains(at)).count();
            let cost = distance_px + 6.0 * covered as f64;
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, field));
            }
        }
        let field = best?.1;
        self.taken.push(field);
        Some(field)
    }

    /// Neither the label nor the line that leads to it covers what is taken.
    fn is_free(&self, anchor: Px2, field: &Field) -> bool {
        const LOOKS: u32 = 8;
        let nearest = field.nearest(anchor);
        let leads_over = |taken: &Field| {
            !taken.contains(anchor)
                && (1..LOOKS)
                    .map(|look| between(anchor, nearest, f64::from(look) / f64::from(LOOKS)))
                    .any(|at| taken.contains(at))
        };
        self.frame.holds(field)
            && !self
                .taken
                .iter()
                .any(|taken| taken.overlaps(field) || leads_over(taken))
    }
}

fn between(from: Px2, to: Px2, share: f64) -> Px2 {
    [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOT: Field = Field {
        min: [200.0, 150.0],
        max: [200.0, 150.0],
    };

    fn labels() -> Labels {
        Labels::new(Field {
            min: [0.0; 2],
            max: [400.0, 300.0],
        })
    }

    #[test]
    fn labels_at_one_place_do_not_overlap_and_end_when_it_is_full() {
        let mut labels = labels();
        let placed: Vec<Field> = (0..100)
            .map_while(|_| labels.place(&DOT, [90.0, 20.0]))
            .collect();
        assert!(placed.len() >= 4 && placed.len() < 100, "{}", placed.len());
        for (index, field) in placed.iter().enumerate() {
            assert!(labels.frame.holds(field));
            assert!(!placed[..index].iter().any(|other| other.overlaps(field)));
        }
    }

    #[test]
    fn nothing_off_the_map_is_named() {
        for value in [-1.0, 1e300, f64::INFINITY, f64::NAN] {
            let place = labels().place(&Field::around([value, 9.0], [0.0; 2]), [90.0, 20.0]);
            assert_eq!(place, None);
        }
    }

    #[test]
    fn a_free_place_is_better_than_one_on_a_line() {
        let mut labels = labels();
        labels.avoid_line([0.0, 130.0], [400.0, 130.0]);
        let field = labels.place(&DOT, [90.0, 20.0]);
        assert!(field.is_some_and(|field| field.min[1] > 130.0), "{field:?}");
    }
}
