//! Reads and writes of the symbol table, beside a mutex, a read-write lock and `arc-swap`: of a small value and of one as large as a
//! scan, alone and with up to six readers beside the one who writes.

mod stores;
mod uses;

use std::time::Duration;

use bytemuck::{Pod, Zeroable};
use coordination::symbols::Datatype;
use onboard::cli::Failure;

use self::stores::{Locked, ReadWriteLocked, Swapped, Symbols};
use self::uses::{Use, Used, clock_ns};
use super::promises::{Figure, Most, Promise};
use super::report::{PartReport, Unit, What};
use super::windows::{Contender, Meter};

/// How many read beside the one who writes.
const READERS: [usize; 6] = [1, 2, 3, 4, 5, 6];

/// A small value, as a pose is.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Small([u64; 4]);

impl Datatype for Small {
    const NAME: &'static str = "pose";
}

/// As large as a scan of 768 beams with its time.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Scan([u64; 196]);

impl Datatype for Scan {
    const NAME: &'static str = "scan";
}

/// Measures for so long.
///
/// # Errors
/// [`Failure`] when there is no room for a symbol table.
pub fn measure(meter: &Meter, time: Duration, part: &mut PartReport) -> Result<(), Failure> {
    let beside = READERS.map(|readers| [Use::Read(readers), Use::Write(readers)]);
    let uses: Vec<Use> = [Use::Alone].into_iter().chain(beside.concat()).collect();
    part.notes.push(format!(
        "figures of calls beside others include {:.0} ns for reading the clock; those alone are means of a thousand",
        clock_ns()
    ));
    let each = time / (2 * uses.len() as u32);
    for what in &uses {
        compare::<Small>(meter, each, part, *what, &of_small(*what))?;
    }
    for what in &uses {
        compare::<Scan>(meter, each, part, *what, &of_scan(*what))?;
    }
    Ok(())
}

/// Nanoseconds, of 32 bytes.
fn of_small(what: Use) -> Vec<Promise> {
    match what {
        Use::Alone => vec![Promise(Figure::P50, Most::Value(16.0))],
        Use::Read(6) => vec![Promise(Figure::P99, Most::Value(150.0))],
        Use::Read(_) | Use::Write(_) => Vec::new(),
    }
}

/// Nanoseconds, of a scan.
fn of_scan(what: Use) -> Vec<Promise> {
    match what {
        Use::Read(6) => vec![Promise(Figure::P99, Most::Value(2_000.0))],
        Use::Alone | Use::Read(_) | Use::Write(_) => Vec::new(),
    }
}

fn compare<T: Datatype>(
    meter: &Meter,
    time: Duration,
    part: &mut PartReport,
    what: Use,
    promises: &[Promise],
) -> Result<(), Failure> {
    if meter.is_over() {
        return Ok(());
    }
    let title = format!("{} of {} bytes, {what}", T::NAME, size_of::<T>());
    let stores = stores::<T>(what)?;
    let what = What::new(&title, Unit::Ns).promising(promises);
    meter.compare(part, &what, time, stores)
}

/// All stores in one use.
fn stores<T: Datatype>(what: Use) -> Result<Vec<Box<dyn Contender>>, Failure> {
    Ok(vec![
        Box::new(Used::<T, Symbols>::new(what)?),
        Box::new(Used::<T, Locked>::new(what)?),
        Box::new(Used::<T, ReadWriteLocked>::new(what)?),
        Box::new(Used::<T, Swapped>::new(what)?),
    ])
}

#[cfg(test)]
mod tests {
    use super::stores::Store;
    use super::*;

    #[test]
    fn every_store_gives_what_was_written() {
        fn check<S: Store<Small>>() {
            let ends = S::ends(Small([1; 4]), 2);
            let Ok((mut write, mut reads, _store)) = ends else {
                panic!("no {}", S::NAME)
            };
            for read in &mut reads {
                assert_eq!(read().0, [1; 4], "{}", S::NAME);
            }
            write(&Small([7; 4]));
            for read in &mut reads {
                assert_eq!(read().0, [7; 4], "{}", S::NAME);
            }
        }
        check::<Symbols>();
        check::<Locked>();
        check::<ReadWriteLocked>();
        check::<Swapped>();
    }

    #[test]
    fn each_use_of_each_store_is_measured() {
        for what in [Use::Alone, Use::Read(2), Use::Write(2)] {
            for mut contender in stores::<Scan>(what).expect("stores") {
                let mut samples = Vec::new();
                { contender.window(Duration::from_millis(2), &mut samples) }.expect("measured");
                assert!(!samples.is_empty(), "{} {what:?}", contender.name());
            }
        }
    }
}
