//! Other processes with one robot's name, and where their bodies stand.
//!
//! Each holds an area from its last report of standing there until a process counts as silent. Several may run at once, and come
//! and go: what one of them says ends no hold of another.

/// More processes of one robot than this are not told from each other. A holder of the robot's certificate can invent any number.
const PROCESSES: usize = 8;

/// A body in an area.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Hold {
    area: usize,
    /// The boot epoch of its process; 0 stands for all beyond [`PROCESSES`].
    process: u64,
    until_ns: u64,
}

/// The bodies of other processes with one robot's name.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seconds(Vec<Hold>);

impl Seconds {
    /// A process says that it stands in an area. Returns whether that is another body there.
    pub(super) fn hold(&mut self, area: usize, process: u64, until_ns: u64) -> bool {
        let process = if self.tells_apart(process) {
            process
        } else {
            0
        };
        let mut holds = self.0.iter_mut();
        if let Some(own) = holds.find(|own| (own.area, own.process) == (area, process)) {
            own.until_ns = own.until_ns.max(until_ns);
            return false;
        }
        self.0.push(Hold {
            area,
            process,
            until_ns,
        });
        true
    }

    fn tells_apart(&self, process: u64) -> bool {
        let mut others: Vec<u64> = self.0.iter().map(|own| own.process).collect();
        others.sort_unstable();
        others.dedup();
        others.contains(&process) || others.len() < PROCESSES
    }

    /// How many bodies are in the area.
    pub(crate) fn bodies(&self, area: usize) -> usize {
        self.0.iter().filter(|own| own.area == area).count()
    }

    /// At least one is in the area.
    pub(crate) fn are_in(&self, area: usize) -> bool {
        self.0.iter().any(|own| own.area == area)
    }

    /// Areas with such a body, sorted.
    pub(crate) fn areas(&self) -> Vec<usize> {
        let mut areas: Vec<usize> = self.0.iter().map(|own| own.area).collect();
        areas.sort_unstable();
        areas.dedup();
        areas
    }

    /// Ends the holds of processes that were heard too long ago. Returns their areas.
    pub(super) fn drop_silent(&mut self, now_ns: u64) -> Vec<usize> {
        let silent = self.0.extract_if(.., |own| now_ns > own.until_ns);
        silent.map(|own| own.area).collect()
    }

    /// The process speaks for the robot from now on. Returns the areas that it held beside it.
    pub(super) fn promote(&mut self, process: u64) -> Vec<usize> {
        let own = self.0.extract_if(.., |own| own.process == process);
        own.map(|own| own.area).collect()
    }

    /// An operator says that none is in the area.
    pub(super) fn leave(&mut self, area: usize) {
        self.0.retain(|own| own.area != area);
    }
}

#[cfg(test)]
mod tests {
    use super::{PROCESSES, Seconds};

    #[test]
    fn what_one_process_says_ends_no_hold_of_another() {
        let mut seconds = Seconds::default();
        assert!(seconds.hold(3, 7, 10) && seconds.hold(3, 8, 20) && seconds.hold(4, 8, 20));
        assert!(!seconds.hold(3, 8, 15), "the same body");
        assert_eq!((seconds.bodies(3), seconds.bodies(4)), (2, 1));
        assert!(seconds.drop_silent(10).is_empty());
        assert_eq!(seconds.drop_silent(16), [3]);
        assert_eq!(seconds.areas(), [3, 4]);
        assert!(seconds.promote(9).is_empty());
        assert_eq!(seconds.promote(8), [3, 4]);
        assert!(seconds.areas().is_empty());
        seconds.hold(3, 8, 20);
        seconds.hold(4, 8, 20);
        seconds.leave(3);
        assert!(!seconds.are_in(3) && seconds.are_in(4));
    }

    #[test]
    fn invented_processes_are_one_body_more_in_each_area() {
        let mut seconds = Seconds::default();
        for process in 1..1000 {
            seconds.hold(3, process, 10);
        }
        assert_eq!(seconds.bodies(3), PROCESSES + 1);
        assert!(seconds.hold(4, 2000, 10) && !seconds.hold(4, 2001, 10));
    }
}
