//! Sets of areas.

use description::areas::{AreaIndex, MAX_AREAS};

const WORDS: usize = MAX_AREAS / 64;

/// A set of areas of the map; copied freely, never on the heap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "symbols", derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(transparent)]
pub struct AreaSet {
    words: [u64; WORDS],
}

#[cfg(feature = "symbols")]
coordination::datatype!(AreaSet, "allowed_areas", description::SYMBOLS);

#[cfg(feature = "symbols")]
impl serde::Serialize for AreaSet {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let areas: Vec<usize> = self.iter().map(AreaIndex::place).collect();
        serializer.collect_map([("areas", areas)])
    }
}

impl AreaSet {
    /// No area.
    pub const EMPTY: Self = Self { words: [0; WORDS] };
    /// Every area that there can be.
    pub const ALL: Self = Self {
        words: [u64::MAX; WORDS],
    };

    /// Whether the area is in it.
    #[must_use]
    pub const fn contains(&self, area: AreaIndex) -> bool {
        self.words[area.place() / 64] >> (area.place() % 64) & 1 == 1
    }

    /// Adds an area; `false` when it was there already.
    pub const fn insert(&mut self, area: AreaIndex) -> bool {
        let new = !self.contains(area);
        self.words[area.place() / 64] |= 1 << (area.place() % 64);
        new
    }

    /// Takes an area out; `false` when it was not there.
    pub const fn remove(&mut self, area: AreaIndex) -> bool {
        let there = self.contains(area);
        self.words[area.place() / 64] &= !(1 << (area.place() % 64));
        there
    }

    /// What either set has.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            words: std::array::from_fn(|word| self.words[word] | other.words[word]),
        }
    }

    /// What both sets have.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        Self {
            words: std::array::from_fn(|word| self.words[word] & other.words[word]),
        }
    }

    /// What this set has and the other has not.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Self {
        Self {
            words: std::array::from_fn(|word| self.words[word] & !other.words[word]),
        }
    }

    /// How many areas are in it.
    #[must_use]
    pub fn len(&self) -> usize {
        self.words
            .iter()
            .map(|word| word.count_ones() as usize)
            .sum()
    }

    /// No area is in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::EMPTY
    }

    /// The areas in it, in the order of the map.
    pub fn iter(&self) -> impl Iterator<Item = AreaIndex> + use<> {
        self.words
            .into_iter()
            .enumerate()
            .flat_map(|(index, word)| {
                // What is left of the word when its lowest bit goes, again and again.
                let rest = |rest: &u64| Some(rest & (rest - 1)).filter(|&rest| rest != 0);
                std::iter::successors(Some(word).filter(|&word| word != 0), rest)
                    .map(move |rest| AreaIndex(index as u8 * 64 + rest.trailing_zeros() as u8))
            })
    }
}

impl FromIterator<AreaIndex> for AreaSet {
    fn from_iter<I: IntoIterator<Item = AreaIndex>>(areas: I) -> Self {
        let mut set = Self::EMPTY;
        for area in areas {
            set.insert(area);
        }
        set
    }
}
