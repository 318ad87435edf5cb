//! Several things that are drawn at once: how usual all of them together are, from how usual each is.

/// How usual one of several independent things is: the share of its distribution that is no more usual (its tail).
#[derive(Debug, Clone, PartialEq)]
pub struct Tail {
    /// Between 0 and 1.
    pub share: f64,
    /// The shares that its distribution has, each with its probability, where they are few: of a list, or 1 alone where everything is
    /// equally usual. Empty where every share between 0 and 1 is as likely as any other, as those of a density without plateaus are.
    pub levels: Vec<(f64, f64)>,
}

/// More combinations of levels are not worked out; the largest lists then count as if every share were as likely as any other, by which
/// the result is rather too large.
const MOST_LEVELS: usize = 20_000;
/// Products that differ by less, relative to themselves, are the same up to rounding.
const SAME: f64 = 1e-9;

impl Tail {
    /// Of what has a density without plateaus.
    pub fn of_density(share: f64) -> Self {
        Self { share, levels: Vec::new() }
    }

    /// Of what is as usual as anything else that is possible, or not possible at all.
    pub fn of_equals(is_possible: bool) -> Self {
        Self { share: if is_possible { 1.0 } else { 0.0 }, levels: vec![(1.0, 1.0)] }
    }

    /// Of one of several with these probabilities, which come to 1; `at` is which it is, if it is any of them.
    pub fn of_list(probabilities: &[f64], at: Option<usize>) -> Self {
        let share = |one: f64| {
            let no_more_usual = probabilities.iter().filter(|other| **other <= one * (1.0 + SAME));
            no_more_usual.sum::<f64>().min(1.0)
        };
        let possible = probabilities.iter().filter(|one| **one > 0.0);
        Self {
            share: at.map_or(0.0, |at| if probabilities[at] > 0.0 { share(probabilities[at]) } else { 0.0 }),
            levels: merged(possible.map(|one| (share(*one), *one)).collect()),
        }
    }
}

/// The share of all that may be drawn together that is no more usual than something with these tails, where the product of tails says what
/// is more usual: exact for independent things, in closed form. `None` of nothing.
///
/// With k tails that are uniform between 0 and 1, their product is at most w with probability w Σ (−ln w)^j / j! over j < k (Fisher 1932:
/// −2 ln w has a χ² distribution of 2 k degrees of freedom). What has levels is summed over them. So the result is at most any `share` in
/// at most that share of all draws, and in exactly that share where something has a density.
pub fn combined_tail(tails: &[Tail]) -> Option<f64> {
    if tails.is_empty() {
        return None;
    }
    // In an order of their own, so that the bits do not depend on the order in which they are declared.
    let mut shares: Vec<f64> = tails.iter().map(|one| one.share).collect();
    shares.sort_by(f64::total_cmp);
    let product: f64 = shares.iter().product();
    let mut uniform = tails.iter().filter(|one| one.levels.is_empty()).count() as u32;
    let mut lists: Vec<&[(f64, f64)]> =
        tails.iter().map(|one| &*one.levels).filter(|levels| !levels.is_empty()).collect();
    lists.sort_by(|one, other| {
        let by_levels = || one.iter().zip(*other).map(|(a, b)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        one.len()
            .cmp(&other.len())
            .then_with(|| by_levels().find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal))
    });
    let mut levels = vec![(1.0, 1.0)];
    for list in lists {
        if levels.len() * list.len() > MOST_LEVELS {
            uniform += 1;
            continue;
        }
        let both = levels.iter().flat_map(|(one, p)| list.iter().map(move |(other, q)| (one * other, p * q)));
        levels = merged(both.collect());
    }
    // Also of what is no number: nobody takes it for usual.
    if product.is_nan() || product <= 0.0 {
        return Some(0.0);
    }
    let below = |(level, probability): &(f64, f64)| probability * product_at_most(product / level, uniform);
    Some(levels.iter().map(below).sum::<f64>().min(1.0))
}

/// The probability that the product of so many independent numbers, each uniform between 0 and 1, is at most `limit`, which is above 0.
fn product_at_most(limit: f64, count: u32) -> f64 {
    if limit >= 1.0 - SAME {
        return 1.0;
    }
    let log = -libm::log(limit);
    let (mut term, mut sum) = (1.0, 0.0);
    for index in 0..count {
        sum += term;
        term *= log / f64::from(index + 1);
    }
    (limit * sum).min(1.0)
}

/// In rising order, with those that are the same up to rounding as one.
fn merged(mut levels: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    levels.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1)));
    levels.dedup_by(|later, kept| {
        let same = later.0 <= kept.0 * (1.0 + SAME);
        kept.1 += if same { later.1 } else { 0.0 };
        same
    });
    levels
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    use super::*;
    use crate::random::Stream;

    #[test]
    fn tails_of_densities_come_to_the_chi_squared_distribution() {
        for shares in [vec![0.3], vec![0.03, 0.7], vec![0.5; 5], vec![1e-6, 0.9, 0.2], vec![1e-200, 1e-200]] {
            let tails: Vec<Tail> = shares.iter().copied().map(Tail::of_density).collect();
            let statistic = -2.0 * shares.iter().map(|one: &f64| one.ln()).sum::<f64>();
            let expected = ChiSquared::new(2.0 * shares.len() as f64).unwrap().sf(statistic);
            let found = combined_tail(&tails).unwrap();
            assert!((found - expected).abs() <= 1e-9 * expected + 1e-300, "{shares:?}: {found} {expected}");
        }
        // One thing is as usual as it is.
        assert!((combined_tail(&[Tail::of_density(0.05)]).unwrap() - 0.05).abs() < 1e-15);
        assert_eq!(combined_tail(&[]), None);
        assert_eq!(combined_tail(&[Tail::of_density(f64::NAN), Tail::of_density(0.5)]), Some(0.0));
    }

    #[test]
    fn what_is_equally_usual_whatever_comes_says_nothing() {
        let alone = combined_tail(&[Tail::of_density(0.01)]);
        let beside = combined_tail(&[Tail::of_equals(true), Tail::of_density(0.01), Tail::of_equals(true)]);
        assert_eq!(alone, beside);
        assert_eq!(combined_tail(&[Tail::of_equals(true)]), Some(1.0));
        assert_eq!(combined_tail(&[Tail::of_equals(false), Tail::of_density(0.9)]), Some(0.0));
    }

    #[test]
    fn lists_are_summed_over_all_that_may_come() {
        // By hand: of two lists, all nine pairs in the order of the product of their tails.
        let (one, other) = ([0.5, 0.3, 0.2], [0.9, 0.1, 0.0]);
        let tail = |list: &[f64], at: usize| Tail::of_list(list, Some(at));
        let pairs = || (0..3).flat_map(|a| (0..2).map(move |b| (a, b)));
        for (a, b) in pairs() {
            let product = |(a, b): (usize, usize)| tail(&one, a).share * tail(&other, b).share;
            let no_more_usual = pairs().filter(|pair| product(*pair) <= product((a, b)) + 1e-12);
            let expected: f64 = no_more_usual.map(|(a, b)| one[a] * other[b]).sum();
            let found = combined_tail(&[tail(&one, a), tail(&other, b)]).unwrap();
            assert!((found - expected).abs() < 1e-12, "{a} {b}: {found} {expected}");
        }
        // What is on no list, and what has no weight, cannot come.
        for never in [Tail::of_list(&one, None), Tail::of_list(&other, Some(2))] {
            assert_eq!(combined_tail(&[never, Tail::of_density(1.0)]), Some(0.0));
        }
        // Two of the same weight are equally usual.
        assert_eq!(Tail::of_list(&[0.25, 0.5, 0.25], Some(0)).share, 0.5);
    }

    /// By another way: the integral over the list of the two uniform shares, on a grid.
    #[test]
    fn a_list_beside_densities_is_what_a_sum_over_a_grid_gives() {
        let list = [0.6, 0.3, 0.1];
        let (at, first, second) = (1, 0.2, 0.4);
        let product = Tail::of_list(&list, Some(at)).share * first * second;
        let steps = 2000;
        let middle = |step: usize| (step as f64 + 0.5) / steps as f64;
        let mut expected = 0.0;
        for (index, weight) in list.iter().enumerate() {
            let level = Tail::of_list(&list, Some(index)).share;
            // For each first share, the second is below what is left of the product.
            let mean =
                (0..steps).map(|step| (product / level / middle(step)).min(1.0)).sum::<f64>() / steps as f64;
            expected += weight * mean;
        }
        let tails = [Tail::of_density(second), Tail::of_list(&list, Some(at)), Tail::of_density(first)];
        let found = combined_tail(&tails).unwrap();
        assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    }

    #[test]
    fn of_what_is_drawn_a_share_is_at_or_below_any_share() {
        let list = [0.55, 0.25, 0.15, 0.05];
        let mut stream = Stream::seeded(7);
        let draws = 40_000;
        let mut found = Vec::with_capacity(draws);
        let mut of_lists = Vec::with_capacity(draws);
        for _ in 0..draws {
            let mut at = || {
                let mut left = stream.uniform();
                list.iter().position(|weight| {
                    left -= weight;
                    left < 0.0
                })
            };
            let (one, other) = (at(), at());
            let listed = [Tail::of_list(&list, one), Tail::of_list(&list, other)];
            of_lists.push(combined_tail(&listed).unwrap());
            let densities = [Tail::of_density(stream.uniform()), Tail::of_density(stream.uniform())];
            found.push(combined_tail(&[&listed[..1], &densities[..]].concat()).unwrap());
        }
        for share in [0.001, 0.01, 0.05, 0.3, 0.8] {
            let below =
                |found: &[f64]| found.iter().filter(|one| **one <= share).count() as f64 / draws as f64;
            let error = (share * (1.0 - share) / draws as f64).sqrt();
            let (with_densities, of_lists) = (below(&found), below(&of_lists));
            assert!((with_densities - share).abs() < 4.0 * error, "{with_densities} at or below {share}");
            assert!(of_lists < share + 4.0 * error, "{of_lists} at or below {share}");
        }
    }

    #[test]
    fn order_changes_no_bit_and_more_unusual_is_never_more_usual() {
        let of = |first: f64, second: f64, at: usize| {
            [
                Tail::of_density(first),
                Tail::of_list(&[0.7, 0.2, 0.1], Some(at)),
                Tail::of_density(second),
                Tail::of_list(&[0.5, 0.3, 0.2], Some(0)),
            ]
        };
        let mut stream = Stream::seeded(3);
        for round in 0..200 {
            let tails = of(stream.uniform(), stream.uniform(), round % 3);
            let all = combined_tail(&tails).unwrap();
            let mut turned = tails.clone();
            turned.rotate_left(1 + round % 3);
            assert_eq!(combined_tail(&turned).unwrap().to_bits(), all.to_bits());
            let mut rarer = tails;
            rarer[0].share *= 0.5;
            assert!(combined_tail(&rarer).unwrap() <= all);
        }
        // So many combinations that they are not worked out: rather too usual than too unusual.
        let long: Vec<f64> = (1..=300).map(|one| f64::from(one) / 45_150.0).collect();
        let many = [Tail::of_list(&long, Some(9)), Tail::of_list(&long, Some(20)), Tail::of_density(0.5)];
        let product: f64 = many.iter().map(|one| one.share).product();
        assert!(combined_tail(&many).unwrap() <= product_at_most(product, 3) + 1e-12);
    }
}
