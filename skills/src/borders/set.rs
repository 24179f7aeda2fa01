//! Sets of areas.

/// Areas that a map, and a set, can hold.
pub const MAX_AREAS: usize = 256;

const WORDS: usize = MAX_AREAS / 64;

/// A set of areas by their index in the map; copied freely, never on the heap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "symbols", derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(transparent)]
pub struct AreaSet {
    words: [u64; WORDS],
}

#[cfg(feature = "symbols")]
coordination::datatype!(AreaSet, "allowed_areas");

#[cfg(feature = "symbols")]
impl serde::Serialize for AreaSet {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let areas: Vec<usize> = self.iter().collect();
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

    /// Whether the area is in it; `false` for an index of [`MAX_AREAS`] or more.
    #[must_use]
    pub const fn contains(&self, area: usize) -> bool {
        area < MAX_AREAS && self.words[area / 64] >> (area % 64) & 1 == 1
    }

    /// Adds an area; `false` when it was there already or its index is too large.
    pub const fn insert(&mut self, area: usize) -> bool {
        let new = area < MAX_AREAS && !self.contains(area);
        if new {
            self.words[area / 64] |= 1 << (area % 64);
        }
        new
    }

    /// Takes an area out; `false` when it was not there.
    pub const fn remove(&mut self, area: usize) -> bool {
        let there = self.contains(area);
        if there {
            self.words[area / 64] &= !(1 << (area % 64));
        }
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

    /// The areas in it, by rising index.
    pub fn iter(&self) -> impl Iterator<Item = usize> + use<> {
        self.words
            .into_iter()
            .enumerate()
            .flat_map(|(index, word)| {
                // What is left of the word when its lowest bit goes, again and again.
                let rest = |rest: &u64| Some(rest & (rest - 1)).filter(|&rest| rest != 0);
                std::iter::successors(Some(word).filter(|&word| word != 0), rest)
                    .map(move |rest| index * 64 + rest.trailing_zeros() as usize)
            })
    }
}

impl FromIterator<usize> for AreaSet {
    /// Indices that are too large are left out.
    fn from_iter<I: IntoIterator<Item = usize>>(areas: I) -> Self {
        let mut set = Self::EMPTY;
        for area in areas {
            set.insert(area);
        }
        set
    }
}
