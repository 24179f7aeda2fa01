//! Cores that real-time threads have for themselves, where a computer has fast and slow ones.

use super::scheduling::{CoreClass, Wanted, capacities, fastest};

/// What the threads of a robot find of cores.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Room {
    /// All cores that this program may use.
    pub cores: usize,
    /// How many of them are fast: all where they are alike.
    pub fast: usize,
    /// Numbers of the fast ones that no thread names by number.
    pub free: Vec<usize>,
    /// Real-time threads, whatever cores they want.
    pub real_time: usize,
    /// Those of them that want a big core.
    pub big: usize,
}

impl Room {
    /// On this computer.
    #[must_use]
    pub fn here(wanted: &[Wanted]) -> Self {
        Self::among(wanted, &capacities())
    }

    /// Among these cores: each one's number, with a figure that tells fast from slow ones.
    #[must_use]
    pub fn among(wanted: &[Wanted], capacities: &[(usize, u64)]) -> Self {
        let fast = fastest(capacities);
        let is_named = |core: usize| {
            let own = CoreClass::Number(core);
            wanted.iter().any(|thread| thread.cores == own)
        };
        Self {
            cores: capacities.len(),
            fast: fast.len(),
            free: { fast.into_iter() }
                .filter(|&core| !is_named(core))
                .collect(),
            real_time: { wanted.iter() }
                .filter(|thread| thread.fifo_priority.is_some())
                .count(),
            big: { wanted.iter() }.filter(|own| wants_big(own)).count(),
        }
    }

    /// No core is faster than another one.
    #[must_use]
    pub fn are_alike(&self) -> bool {
        self.fast == self.cores
    }

    /// Each real-time thread that wants a big core gets one of its own.
    #[must_use]
    pub fn is_enough(&self) -> bool {
        !self.are_alike() && self.free.len() >= self.big
    }
}

fn wants_big(thread: &Wanted) -> bool {
    thread.cores == CoreClass::Big && thread.fifo_priority.is_some()
}

/// Gives each real-time thread that wants a big core one of its own, where there are enough of them: the others then never make it
/// wait. Where all cores are alike, `big` means any, and nothing changes: real-time threads push one another to cores that are free,
/// and several robots in one computer would choose the same ones.
#[must_use]
pub fn with_own_cores(wanted: &[Wanted]) -> Vec<Wanted> {
    spread(wanted, &capacities())
}

fn spread(wanted: &[Wanted], capacities: &[(usize, u64)]) -> Vec<Wanted> {
    let room = Room::among(wanted, capacities);
    let mut free = room.free.iter().copied().rev();
    { wanted.iter() }
        .map(|thread| {
            let own = if room.is_enough() && wants_big(thread) {
                free.next()
            } else {
                None
            };
            Wanted {
                cores: own.map_or(thread.cores, CoreClass::Number),
                ..*thread
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_thread_gets_a_big_core_where_there_are_enough() {
        // As an Exynos 5422 has them.
        let xu4: Vec<(usize, u64)> = (0..8)
            .map(|n| (n, if n < 4 { 448 } else { 1024 }))
            .collect();
        let thread = |fifo_priority, cores| Wanted {
            fifo_priority,
            cores,
        };
        let table = [
            thread(Some(80), CoreClass::Big),
            thread(None, CoreClass::Big),
            thread(Some(70), CoreClass::Big),
            thread(Some(60), CoreClass::Little),
            thread(Some(50), CoreClass::Big),
        ];
        let cores = |wanted: &[Wanted], capacities: &[(usize, u64)]| {
            let spread = spread(wanted, capacities);
            spread.iter().map(|own| own.cores).collect::<Vec<_>>()
        };
        let own = CoreClass::Number;
        let (big, little) = (CoreClass::Big, CoreClass::Little);
        assert_eq!(cores(&table, &xu4), [own(7), big, own(6), little, own(5)]);
        // One that the file gives away is not given twice.
        let mut named = table;
        named[1] = thread(None, own(7));
        assert_eq!(
            cores(&named, &xu4),
            [own(6), own(7), own(5), little, own(4)]
        );
        let room = Room {
            cores: 8,
            fast: 4,
            free: vec![4, 5, 6],
            real_time: 4,
            big: 3,
        };
        assert_eq!(Room::among(&named, &xu4), room);
        assert!(room.is_enough() && !room.are_alike());
        // Too few, or all alike: as it was.
        assert_eq!(cores(&table, &xu4[..6]), [big, big, big, little, big]);
        assert_eq!(cores(&table, &xu4[4..]), [big, big, big, little, big]);
    }
}
