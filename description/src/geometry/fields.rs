//! Geometry as values of keys: how poses, points, segments and rectangles are written in files.

use super::motion::{Point2, Pose2};
use super::shape::{Rect, Segment};
use crate::keys::{
    ANGLE, Corners, Ends, Fault, Field, KeyError, Need, Optional, Page, Pose, Quantity, Source,
    none,
};

const POSE: &str = "a pose { x_m = …, y_m = …, theta_rad = … }";

impl Field<Pose> for Pose2 {
    fn read(s: &dyn Source, key: &'static str, rule: &Pose, _: Option<Self>) -> Self {
        let mut pose = Self::new(f64::NAN, f64::NAN, f64::NAN);
        s.table(key, POSE, Need::Required, &mut |s| {
            let number =
                |key, quantity| s.number(key, quantity, Need::Required).unwrap_or(f64::NAN);
            pose = Self::new(
                number("x_m", &rule.0),
                number("y_m", &rule.0),
                number("theta_rad", &ANGLE),
            );
        });
        pose
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &Pose,
        _: Option<Self>,
        about: &'static str,
    ) {
        page.key(
            key,
            format!("{POSE}, each {}", rule.0.describe()),
            None,
            about,
        );
    }
}

impl Field<Optional<Pose>> for Option<Pose2> {
    fn read(s: &dyn Source, key: &'static str, rule: &Optional<Pose>, _: Option<Self>) -> Self {
        s.has(key).then(|| Pose2::read(s, key, &rule.0, None))
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        _: &Optional<Pose>,
        _: Option<Self>,
        about: &'static str,
    ) {
        page.key(key, POSE, none(), about);
    }
}

impl Field<Quantity> for Point2 {
    fn read(s: &dyn Source, key: &'static str, rule: &Quantity, _: Option<Self>) -> Self {
        Self::from(s.point(key, rule))
    }

    fn check(&self, key: &str, rule: &Quantity) -> Result<(), KeyError> {
        self.x_m.check(key, rule)?;
        self.y_m.check(key, rule)
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &Quantity,
        _: Option<Self>,
        about: &'static str,
    ) {
        page.key(
            key,
            format!("[x, y], each {}", rule.describe()),
            None,
            about,
        );
    }
}

impl Field<Ends> for Segment {
    fn read(s: &dyn Source, _: &'static str, rule: &Ends, _: Option<Self>) -> Self {
        let end = |key| Point2::from(s.point(key, &rule.0));
        Self::new(end("from_m"), end("to_m"))
    }

    fn check(&self, _: &str, rule: &Ends) -> Result<(), KeyError> {
        self.a.check("from_m", &rule.0)?;
        self.b.check("to_m", &rule.0)
    }

    fn document(page: &mut Page, _: &'static str, rule: &Ends, _: Option<Self>, _: &'static str) {
        let value = format!("[x, y], each {}", rule.0.describe());
        page.key(
            "from_m",
            value.as_str(),
            None,
            "One end, or where it starts.",
        );
        page.key("to_m", value, None, "The other end.");
    }
}

const CORNERS: &str = "a rectangle { min_m = [x, y], max_m = [x, y] }";

impl Field<Corners> for Rect {
    fn read(s: &dyn Source, key: &'static str, rule: &Corners, _: Option<Self>) -> Self {
        let mut rect = Self::default();
        s.table(key, CORNERS, Need::Required, &mut |s| {
            let ([x0, y0], [x1, y1]) = (s.point("min_m", &rule.0), s.point("max_m", &rule.0));
            if x1 <= x0 || y1 <= y0 {
                s.refuse(
                    Fault::Inconsistent,
                    "max_m",
                    format!("[{x1:?}, {y1:?}]"),
                    format!("a corner north-east of min_m [{x0:?}, {y0:?}]"),
                );
            }
            rect = Self {
                min: Point2::new(x0, y0),
                max: Point2::new(x1, y1),
            };
        });
        rect
    }

    fn check(&self, key: &str, rule: &Corners) -> Result<(), KeyError> {
        self.min.check(&format!("{key}.min_m"), &rule.0)?;
        self.max.check(&format!("{key}.max_m"), &rule.0)
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &Corners,
        _: Option<Self>,
        about: &'static str,
    ) {
        page.key(
            key,
            format!("{CORNERS}, each {}", rule.0.describe()),
            None,
            about,
        );
    }
}

impl Field<Optional<Corners>> for Option<Rect> {
    fn read(s: &dyn Source, key: &'static str, rule: &Optional<Corners>, _: Option<Self>) -> Self {
        s.has(key).then(|| Rect::read(s, key, &rule.0, None))
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        _: &Optional<Corners>,
        _: Option<Self>,
        about: &'static str,
    ) {
        page.key(key, CORNERS, none(), about);
    }
}
