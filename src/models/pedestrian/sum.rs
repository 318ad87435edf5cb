//! Sums of vectors that do not depend on the order of their terms.

use nalgebra::Vector2;

/// The sum of `terms`, the same bits in whatever order they come; of none it is zero.
pub(super) fn sum_in_any_order(terms: impl Iterator<Item = Vector2<f64>> + Clone) -> Vector2<f64> {
    // Of two terms sums are the same bits anyway.
    if terms.clone().nth(2).is_none() {
        return terms.sum();
    }
    let order =
        |one: &Vector2<f64>, other: &Vector2<f64>| one.x.total_cmp(&other.x).then(one.y.total_cmp(&other.y));
    let mut sum = Vector2::zeros();
    let mut last: Option<Vector2<f64>> = None;
    // From the least to the largest, equal ones together, without room to sort them in.
    loop {
        let left = terms.clone().filter(|term| last.is_none_or(|last| order(term, &last).is_gt()));
        let Some(next) = left.min_by(order) else { return sum };
        let equal = terms.clone().filter(|term| order(term, &next).is_eq()).count();
        (0..equal).for_each(|_| sum += next);
        last = Some(next);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn sums_do_not_depend_on_the_order(
            terms in prop::collection::vec((-1e3..1e3, -1e-3..1e3), 0..6)
                .prop_flat_map(|terms| (Just(terms.clone()), Just(terms).prop_shuffle())),
        ) {
            let sum = |terms: &[(f64, f64)]| sum_in_any_order(terms.iter().map(|(x, y)| Vector2::new(*x, *y)));
            let (one, other) = (sum(&terms.0), sum(&terms.1));
            prop_assert_eq!(one, other);
            let plain: f64 = terms.0.iter().map(|(x, _)| x).sum();
            prop_assert!((one.x - plain).abs() < 1e-9);
        }
    }
}
