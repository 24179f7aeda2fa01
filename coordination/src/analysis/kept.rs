//! A set of states that nobody adds to any more.

/// No state at all.
pub(super) const NOWHERE: u32 = 0;
/// The state in which no further variable is true.
pub(super) const HERE: u32 = 1;

/// A decision diagram that can only be asked: one look at a node for each variable that is passed.
#[derive(Debug, Default)]
pub(in crate::analysis) struct Kept {
    /// Variable, and where to go on with it and without it; numbered from two.
    nodes: Vec<(u32, u32, u32)>,
    pub(super) root: u32,
}

impl Kept {
    pub(super) fn add(&mut self, variable: u32, with: u32, without: u32) -> u32 {
        self.nodes.push((variable, with, without));
        self.nodes.len() as u32 + 1
    }

    /// Whether the state is in it whose true variables these are, in ascending order.
    pub(in crate::analysis) fn contains(&self, variables: impl IntoIterator<Item = u32>) -> bool {
        let mut at = self.root;
        for variable in variables {
            loop {
                let Some(&(own, with, without)) = self.node(at) else {
                    return false;
                };
                match own.cmp(&variable) {
                    std::cmp::Ordering::Less => at = without,
                    std::cmp::Ordering::Equal => {
                        at = with;
                        break;
                    }
                    std::cmp::Ordering::Greater => return false,
                }
            }
        }
        while let Some(&(_, _, without)) = self.node(at) {
            at = without;
        }
        at == HERE
    }

    fn node(&self, at: u32) -> Option<&(u32, u32, u32)> {
        self.nodes.get(at.checked_sub(2)? as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_has_just_the_states_that_were_put_in() {
        // {0, 2}, {1} and {}.
        let mut kept = Kept::default();
        let two = kept.add(2, HERE, NOWHERE);
        let one = kept.add(1, HERE, HERE);
        kept.root = kept.add(0, two, one);
        for (state, is_in) in [
            (&[0, 2][..], true),
            (&[1], true),
            (&[], true),
            (&[0], false),
            (&[2], false),
            (&[0, 1], false),
            (&[0, 2, 3], false),
        ] {
            assert_eq!(kept.contains(state.iter().copied()), is_in, "{state:?}");
        }
        assert!(!Kept::default().contains([]));
    }
}
