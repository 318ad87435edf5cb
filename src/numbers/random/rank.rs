//! Ranks of names, so that who draws what does not depend on the order in which things are declared.

/// The place of each of `names` in alphabetical order, from 0. Equal names keep their order.
pub fn ranks(names: &[&str]) -> Vec<usize> {
    let place = |(index, name): (usize, &&str)| {
        names.iter().enumerate().filter(|(other, before)| (**before, *other) < (*name, index)).count()
    };
    names.iter().enumerate().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_follow_the_names_in_whatever_order_they_stand() {
        assert_eq!(ranks(&["walker", "child", "aunt"]), [2, 1, 0]);
        assert_eq!(ranks(&["aunt", "walker", "child"]), [0, 2, 1]);
        assert_eq!(ranks(&["a", "b", "a"]), [0, 2, 1]);
        assert_eq!(ranks(&["av"]), [0]);
    }
}
