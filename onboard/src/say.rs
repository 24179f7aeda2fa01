//! Lines for people on standard output. Whoever closes it early has read enough: that is no failure, and no panic.

/// Writes a line, as `println!` does.
#[macro_export]
macro_rules! say {
    ($($what:tt)*) => {
        $crate::say::line(::std::format_args!($($what)*))
    };
}

/// Writes a line.
pub fn line(what: std::fmt::Arguments<'_>) {
    use std::io::Write;
    let _ = writeln!(std::io::stdout().lock(), "{what}");
}
