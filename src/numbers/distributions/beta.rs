//! The beta distribution, and the tails of the binomial and of Student's distribution that follow from it.

/// The regularised incomplete beta function I_x(a, b) for a, b > 0.
///
/// Source: NIST Digital Library of Mathematical Functions, 8.17.4 and the continued fraction 8.17.22.
pub fn regularised_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    // The fraction converges fast below the mean; above it the mirrored one does.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - regularised_beta_below(1.0 - x, b, a);
    }
    regularised_beta_below(x, a, b)
}

fn regularised_beta_below(x: f64, a: f64, b: f64) -> f64 {
    let front = libm::exp(a * libm::log(x) + b * libm::log1p(-x) - ln_beta(a, b)) / a;
    front / fraction(x, a, b)
}

/// 1 + d1/(1 + d2/(1 + ...)) with the coefficients of DLMF 8.17.23, by convergents kept in scale.
fn fraction(x: f64, a: f64, b: f64) -> f64 {
    let coefficient = |index: u32| {
        let m = f64::from(index / 2);
        if index.is_multiple_of(2) {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        }
    };
    let (mut above, mut below) = ((1.0, 1.0), (0.0, 1.0));
    let mut value = 1.0;
    for index in 1..100_000 {
        let d = coefficient(index);
        above = (above.1, above.1 + d * above.0);
        below = (below.1, below.1 + d * below.0);
        // Dividing both by the same number leaves the convergent and keeps it from overflowing.
        let scale = 1.0 / below.1;
        above = (above.0 * scale, above.1 * scale);
        below = (below.0 * scale, 1.0);
        let next = above.1;
        if (next - value).abs() <= 1e-16 * next.abs() {
            return next;
        }
        value = next;
    }
    value
}

/// ln B(a, b).
pub fn ln_beta(a: f64, b: f64) -> f64 {
    libm::lgamma(a) + libm::lgamma(b) - libm::lgamma(a + b)
}

/// The quantile of the beta distribution at probability `p`.
pub fn beta_quantile(p: f64, a: f64, b: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if regularised_beta(middle, a, b) < p {
            low = middle
        } else {
            high = middle
        }
        // Far below what any number of runs can tell.
        if high - low <= 1e-15 * high {
            return 0.5 * (low + high);
        }
    }
}

/// The share of values whose density is no higher than at `x`: 0 outside of 0..1. Where the density has its only peak or dip inside, the
/// place on its other side that is as dense is found by halving, to the last digit. Not for a = b = 1, where all is equally dense.
pub fn beta_tail(x: f64, a: f64, b: f64) -> f64 {
    if !(0.0..=1.0).contains(&x) {
        return 0.0;
    }
    let below = |x: f64| regularised_beta(x, a, b);
    let above = |x: f64| regularised_beta(1.0 - x, b, a);
    match (a - 1.0, b - 1.0) {
        // Falling or rising everywhere.
        (rise, fall) if rise <= 0.0 && fall >= 0.0 => above(x),
        (rise, fall) if rise >= 0.0 && fall <= 0.0 => below(x),
        (rise, fall) => {
            let log_density = |x: f64| rise * libm::log(x) + fall * libm::log1p(-x);
            let turn = rise / (rise + fall);
            let (height, is_peak) = (log_density(x), rise > 0.0);
            // Between the turn and the end on the other side; there the density goes down from a peak, and up from a dip.
            let (mut near, mut far) = if x < turn { (turn, 1.0) } else { (turn, 0.0) };
            loop {
                let middle = 0.5 * (near + far);
                if middle == near || middle == far {
                    break;
                }
                let is_nearer = (log_density(middle) > height) == is_peak;
                *(if is_nearer { &mut near } else { &mut far }) = middle;
            }
            let (low, high) = if x < turn { (x, far) } else { (far, x) };
            let share = if is_peak { below(low) + above(high) } else { 1.0 - below(low) - above(high) };
            share.clamp(0.0, 1.0)
        }
    }
}

/// P(X >= k) for X successes in n tries of probability p.
pub fn binomial_at_least(k: u64, n: u64, p: f64) -> f64 {
    match k {
        0 => 1.0,
        _ if k > n => 0.0,
        _ => regularised_beta(p, k as f64, (n - k) as f64 + 1.0),
    }
}

/// P(X <= k) for X successes in n tries of probability p.
pub fn binomial_at_most(k: u64, n: u64, p: f64) -> f64 {
    if k >= n { 1.0 } else { regularised_beta(1.0 - p, (n - k) as f64, k as f64 + 1.0) }
}

/// P(T >= t) for Student's t with `freedom` degrees of freedom.
pub fn student_above(t: f64, freedom: f64) -> f64 {
    let outside = 0.5 * regularised_beta(freedom / (freedom + t * t), freedom / 2.0, 0.5);
    if t >= 0.0 { outside } else { 1.0 - outside }
}

/// The quantile at probability `p` of Student's t with `freedom` degrees of freedom.
pub fn student_quantile(p: f64, freedom: f64) -> f64 {
    let x = beta_quantile(2.0 * p.min(1.0 - p), freedom / 2.0, 0.5);
    let size = (freedom * (1.0 - x) / x).sqrt();
    if p < 0.5 { -size } else { size }
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{Beta, ContinuousCDF, StudentsT};

    use super::*;

    #[test]
    fn the_beta_distribution_agrees_with_another_implementation() {
        for (a, b) in [(1.0, 1.0), (0.5, 3.0), (3.0, 297.0), (150.0, 151.0), (2000.0, 5.0), (40.0, 0.7)] {
            let reference = Beta::new(a, b).unwrap();
            for k in 1..50 {
                let x = f64::from(k) / 50.0;
                let (found, expected) = (regularised_beta(x, a, b), reference.cdf(x));
                assert!((found - expected).abs() < 1e-11, "I_{x}({a}, {b}) = {found}, {expected}");
                let p = x;
                assert!((regularised_beta(beta_quantile(p, a, b), a, b) - p).abs() < 1e-10, "{p} {a} {b}");
            }
        }
    }

    #[test]
    fn binomial_tails_are_sums_of_their_terms() {
        let (n, p) = (12_u64, 0.3_f64);
        let term = |k: u64| {
            let choose = (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64);
            choose * p.powi(k as i32) * (1.0 - p).powi((n - k) as i32)
        };
        for k in 0..=n {
            let below: f64 = (0..=k).map(term).sum();
            assert!((binomial_at_most(k, n, p) - below).abs() < 1e-13);
            let above: f64 = (k..=n).map(term).sum();
            assert!((binomial_at_least(k, n, p) - above).abs() < 1e-13);
        }
    }

    #[test]
    fn students_distribution_agrees_with_another_implementation() {
        for freedom in [1.0, 4.0, 19.0, 79.0, 1999.0] {
            let reference = StudentsT::new(0.0, 1.0, freedom).unwrap();
            for t in [-6.0, -1.0, 0.0, 0.3, 2.0, 4.5] {
                let (found, expected) = (student_above(t, freedom), reference.sf(t));
                assert!((found - expected).abs() < 1e-10, "{t} {freedom}: {found} {expected}");
            }
            for p in [1e-4, 0.025, 0.4, 0.8, 0.975] {
                let found = student_quantile(p, freedom);
                assert!((student_above(found, freedom) - (1.0 - p)).abs() < 1e-10, "{p} {freedom}");
            }
        }
        assert!((student_quantile(0.975, 29.0) - 2.045_229_642).abs() < 1e-8);
    }

    #[test]
    fn small_tails_keep_their_relative_precision() {
        // All of 1000 tries: p^1000.
        let found = binomial_at_least(1000, 1000, 0.5);
        assert!((found / 0.5_f64.powi(1000) - 1.0).abs() < 1e-11, "{found}");
    }
}
