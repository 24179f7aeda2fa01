//! Who plays which role.

/// A different robot for each role, if there is one (augmenting paths, Kuhn 1955).
pub(crate) fn distinct(candidates: &[Vec<usize>]) -> Option<Vec<usize>> {
    fn place(
        role: usize,
        candidates: &[Vec<usize>],
        seen: &mut Vec<usize>,
        chosen: &mut Vec<Option<usize>>,
    ) -> bool {
        for &robot in &candidates[role] {
            if seen.contains(&robot) {
                continue;
            }
            seen.push(robot);
            let other = chosen.iter().position(|&taken| taken == Some(robot));
            if other.is_none_or(|other| place(other, candidates, seen, chosen)) {
                chosen[role] = Some(robot);
                return true;
            }
        }
        false
    }
    let mut chosen = vec![None; candidates.len()];
    for role in 0..candidates.len() {
        if !place(role, candidates, &mut Vec::new(), &mut chosen) {
            return None;
        }
    }
    chosen.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::distinct;

    #[test]
    fn each_role_gets_another_robot() {
        assert_eq!(distinct(&[vec![0, 1], vec![0]]), Some(vec![1, 0]));
        assert_eq!(distinct(&[vec![0], vec![0]]), None);
        assert_eq!(
            distinct(&[vec![0, 1], vec![0, 2], vec![0]]),
            Some(vec![1, 2, 0])
        );
        assert_eq!(distinct(&[]), Some(vec![]));
    }
}
