//! Sets that are joined, and whether a ring among them parts two points.
//!
//! The union-find of B. A. Galler and M. J. Fischer (1964), where each link also knows whether it crosses the line between
//! the points an odd number of times. Joined things that close a ring whose links cross it an odd number of times in all
//! have one of the points inside and the other outside (the Jordan curve theorem).

/// Numbered things, each alone at first.
pub(crate) struct Parts {
    /// Of each the one it hangs on, itself at the top, and whether the way there crosses an odd number of times.
    above: Vec<(u32, bool)>,
    size: Vec<u32>,
}

impl Parts {
    pub(crate) fn new(count: usize) -> Self {
        Self { above: (0..count as u32).map(|at| (at, false)).collect(), size: vec![1; count] }
    }

    /// Joins two by a link; whether that closes a ring that parts the points.
    pub(crate) fn join(&mut self, one: u32, other: u32, is_odd: bool) -> bool {
        let ((top, odd), (other_top, other_odd)) = (self.top(one), self.top(other));
        let is_odd = is_odd ^ odd ^ other_odd;
        if top == other_top {
            return is_odd;
        }
        let (large, small) = if self.size[top as usize] < self.size[other_top as usize] {
            (other_top, top)
        } else {
            (top, other_top)
        };
        self.size[large as usize] += self.size[small as usize];
        self.above[small as usize] = (large, is_odd);
        false
    }

    /// Whether two are joined, and a link between them that crosses nothing would tell nothing new.
    pub(crate) fn are_one(&mut self, one: u32, other: u32) -> bool {
        self.top(one) == self.top(other)
    }

    /// One of those that are joined with it, the same for all of them.
    pub(crate) fn of(&mut self, at: u32) -> u32 {
        self.top(at).0
    }

    /// What it hangs on in the end, and whether the way there crosses an odd number of times.
    fn top(&mut self, mut at: u32) -> (u32, bool) {
        let mut is_odd = false;
        loop {
            let (next, odd) = self.above[at as usize];
            if next == at {
                return (at, is_odd);
            }
            let (over, over_odd) = self.above[next as usize];
            // Halves the way for the next time.
            self.above[at as usize] = (over, if over == next { odd } else { odd ^ over_odd });
            is_odd ^= self.above[at as usize].1;
            at = over;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_parts_when_it_crosses_an_odd_number_of_times() {
        for crossings in [[true, false, false, false], [true, true, true, false], [true, true, false, false]]
        {
            let mut parts = Parts::new(5);
            let links = [(0, 1), (1, 2), (2, 3), (3, 0)];
            let closed: Vec<bool> =
                links.into_iter().zip(crossings).map(|((a, b), odd)| parts.join(a, b, odd)).collect();
            let is_odd = crossings.iter().filter(|odd| **odd).count() % 2 == 1;
            assert_eq!(closed, [false, false, false, is_odd]);
            assert!(!parts.join(4, 2, true), "one that hangs on by a single link closes nothing");
        }
    }
}
