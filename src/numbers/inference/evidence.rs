//! Evidence that something got worse in pairs of runs, which may be looked at as often as one likes.

/// Shares of what can be lost at most in a pair, of which each is staked by a part of the evidence.
const STAKES: u32 = 32;

/// How many times as much whoever had bet on changes for the worse would own, betting against a mean of `margin`.
///
/// If the mean change is at most `margin`, evidence of 1/α is ever reached with a probability of at most α (J. Ville 1939), however often
/// one looks. It is a mean over fixed stakes, each of which multiplies what it owns by 1 + stake × (change − margin) per pair; of changes from
/// −1 to 1 no stake can owe anything.
///
/// Pairs need not be alike: of kinds of pairs that come in rounds of one each, independent of each other, it holds of the mean over the kinds
/// as long as one looks only after whole rounds. (What a round multiplies by has a mean of at most 1, since a product of numbers is at most the
/// power of their mean.)
///
/// Source: I. Waudby-Smith & A. Ramdas, J. R. Stat. Soc. B 86, 2024, section 4 (bets); A. Ramdas, P. Grünwald, V. Vovk & G. Shafer,
/// Statistical Science 38, 2023 (e-processes).
///
/// # Panics
/// If a change is not within −1..1, or the margin not within 0..1.
pub fn evidence_of_worse(changes: impl IntoIterator<Item = f64>, margin: f64) -> f64 {
    assert!((0.0..=1.0).contains(&margin), "a margin of {margin}");
    let mut owned = [0.0_f64; STAKES as usize];
    // What most pairs come to is counted, so that many runs take no more logarithms than few.
    let mut counts = [0_u32; 3];
    for change in changes {
        assert!((-1.0..=1.0).contains(&change), "a change of {change}");
        if change.fract() == 0.0 {
            counts[(change + 1.0) as usize] += 1;
            continue;
        }
        for (owned, stake) in owned.iter_mut().zip(stakes(margin)) {
            *owned += libm::log1p(stake * (change - margin));
        }
    }
    for (owned, stake) in owned.iter_mut().zip(stakes(margin)) {
        for (change, count) in [-1.0, 0.0, 1.0].into_iter().zip(counts).filter(|(_, count)| *count > 0) {
            *owned += f64::from(count) * libm::log1p(stake * (change - margin));
        }
    }
    owned.iter().map(|owned| libm::exp(*owned)).sum::<f64>() / f64::from(STAKES)
}

/// At most 1 / (1 + margin), which loses everything in a pair that got better.
fn stakes(margin: f64) -> impl Iterator<Item = f64> {
    (0..STAKES).map(move |index| (f64::from(index) + 0.5) / f64::from(STAKES) / (1.0 + margin))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    #[test]
    fn pairs_that_do_not_differ_say_nothing() {
        assert_eq!(evidence_of_worse([], 0.0), 1.0);
        assert_eq!(evidence_of_worse([0.0; 50], 0.0), 1.0);
        let with_zeros = evidence_of_worse([1.0, 0.0, 1.0, 0.0, -1.0], 0.0);
        assert_eq!(with_zeros, evidence_of_worse([-1.0, 1.0, 1.0], 0.0));
        // With a margin they speak for it.
        assert!(evidence_of_worse([0.0; 50], 0.02) < 1.0);
    }

    /// Of stakes spread evenly over 0..1 and worse pairs alone, the integral of (1 + stake)^n is (2^(n+1) − 1) / (n + 1).
    #[test]
    fn of_worse_pairs_alone_it_is_what_the_integral_says() {
        for pairs in [1, 5, 10, 20_i32] {
            let found = evidence_of_worse(vec![1.0; pairs as usize], 0.0);
            let exact = (libm::pow(2.0, f64::from(pairs) + 1.0) - 1.0) / f64::from(pairs + 1);
            assert!((found / exact - 1.0).abs() < 0.01, "{pairs}: {found} {exact}");
        }
    }

    /// The second derivation: the mean over all ways in which pairs may come out is 1 where the null hypothesis just holds.
    #[test]
    fn at_the_border_its_mean_is_one() {
        for (worse, better, margin) in [(0.3, 0.3, 0.0), (0.25, 0.15, 0.1), (0.02, 0.0, 0.02)] {
            let mut mean = 0.0;
            let chances = [(1.0, worse), (-1.0, better), (0.0, 1.0 - worse - better)];
            for way in 0..3_usize.pow(6) {
                let (mut rest, mut chance, mut changes) = (way, 1.0, Vec::new());
                for _ in 0..6 {
                    let (change, likely) = chances[rest % 3];
                    changes.push(change);
                    chance *= likely;
                    rest /= 3;
                }
                mean += chance * evidence_of_worse(changes, margin);
            }
            assert!((mean - 1.0).abs() < 1e-12, "{worse} {better} {margin}: {mean}");
        }
    }

    /// Looked at after every pair, and after every round of two kinds of which one got better by what the other got worse.
    #[test]
    fn it_is_seldom_misled_however_often_one_looks() {
        const EXPERIMENTS: u32 = 2000;
        let mut stream = Stream::seeded(20_261_126);
        let mut pair = |worse: f64, better: f64| {
            let lot = stream.uniform();
            if lot < worse { 1.0 } else { -f64::from(lot < worse + better) }
        };
        let (mut alike, mut in_rounds, mut graded) = (0, 0, 0);
        for _ in 0..EXPERIMENTS {
            let mut seen = Vec::new();
            alike += u32::from((0..150).any(|_| {
                seen.push(pair(0.2, 0.2));
                evidence_of_worse(seen.iter().copied(), 0.0) >= 20.0
            }));
            seen.clear();
            in_rounds += u32::from((0..75).any(|_| {
                seen.extend([pair(0.4, 0.0), pair(0.0, 0.4)]);
                evidence_of_worse(seen.iter().copied(), 0.0) >= 20.0
            }));
            seen.clear();
            graded += u32::from((0..100).any(|_| {
                seen.push(0.25 * (pair(0.3, 0.2) + pair(0.3, 0.2) + pair(0.2, 0.3) + pair(0.2, 0.2)));
                evidence_of_worse(seen.iter().copied(), 0.025) >= 20.0
            }));
        }
        // At most 5 %, of which three standard errors of the simulation are 1.5 %.
        for (what, misled) in [("alike", alike), ("in rounds", in_rounds), ("graded", graded)] {
            let share = f64::from(misled) / f64::from(EXPERIMENTS);
            assert!(share < 0.065, "{what}: {share}");
        }
        assert!(alike > 20, "it gives away all: {alike}");
    }
}
