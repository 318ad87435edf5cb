//! The space of rare events: standard normal coordinates for what is continuous, categories for what is chosen.

use crate::distributions::normal;

/// What a coordinate between 0 and 1 decides.
#[derive(Debug, Clone, PartialEq)]
pub enum RareAxis {
    /// A number, by a quantile.
    Continuous,
    /// One of these, in proportion to their weights (not negative, not all 0): each has a part of 0..1, in this order.
    Categories(Vec<f64>),
}

/// The axes of points.
#[derive(Debug, Clone, PartialEq)]
pub struct RareSpace {
    axes: Vec<RareAxis>,
    /// Of each axis of categories, their shares.
    shares: Vec<Vec<f64>>,
}

/// A point in the coordinates that densities are of.
#[derive(Debug, Clone, PartialEq)]
pub struct RarePlace {
    /// Standard normal under the distribution that is drawn from, in the order of the continuous axes.
    pub z: Vec<f64>,
    /// In the order of the other axes.
    pub categories: Vec<usize>,
}

impl RareSpace {
    /// Of at least one axis.
    pub fn new(axes: Vec<RareAxis>) -> Self {
        let shares = |axis: &RareAxis| match axis {
            RareAxis::Continuous => None,
            RareAxis::Categories(weights) => {
                let all: f64 = weights.iter().sum();
                Some(weights.iter().map(|weight| weight / all).collect())
            }
        };
        let shares = axes.iter().filter_map(shares).collect();
        Self { axes, shares }
    }

    /// How many coordinates a point has.
    pub fn dimensions(&self) -> usize {
        self.axes.len()
    }

    /// How many axes are continuous.
    pub(super) fn continuous(&self) -> usize {
        self.axes.len() - self.shares.len()
    }

    /// Of each axis of categories, the shares that are drawn from.
    pub(super) fn shares(&self) -> &[Vec<f64>] {
        &self.shares
    }

    /// Where a point with these coordinates, each above 0 and below 1, lies.
    pub(super) fn place(&self, point: &[f64]) -> RarePlace {
        let mut place = RarePlace { z: Vec::new(), categories: Vec::new() };
        for (axis, share) in self.axes.iter().zip(point) {
            match axis {
                RareAxis::Continuous => place.z.push(normal::quantile(*share)),
                RareAxis::Categories(_) => {
                    let shares = &self.shares[place.categories.len()];
                    place.categories.push(category(shares, *share));
                }
            }
        }
        place
    }

    /// Its coordinates; those of categories are in the middle of their part.
    pub(super) fn point(&self, place: &RarePlace) -> Vec<f64> {
        let (mut z, mut categories) = (place.z.iter(), place.categories.iter().zip(&self.shares));
        let coordinate = |axis: &RareAxis| match axis {
            RareAxis::Continuous => within(normal::cumulative(*z.next().expect("of that axis"))),
            RareAxis::Categories(_) => {
                let (category, shares) = categories.next().expect("of that axis");
                let before: f64 = shares[..*category].iter().sum();
                within(before + 0.5 * shares[*category])
            }
        };
        self.axes.iter().map(coordinate).collect()
    }

    /// Two places farther from each other than this are of different regions unless others lie between.
    pub(super) fn apart(&self) -> f64 {
        1.0 + (self.continuous() as f64).sqrt()
    }

    /// How far two places are from each other; those of other categories are as far as [`Self::apart`] where there are few of them.
    pub(super) fn distance(&self, one: &RarePlace, other: &RarePlace) -> f64 {
        let squares: f64 = one.z.iter().zip(&other.z).map(|(a, b)| (a - b) * (a - b)).sum();
        let differ = |((a, b), shares): ((&usize, &usize), &Vec<f64>)| a != b && shares.len() <= FEW;
        let differ =
            one.categories.iter().zip(&other.categories).zip(&self.shares).filter(|one| differ(*one)).count();
        (squares + differ as f64 * self.apart() * self.apart()).sqrt()
    }
}

/// So many categories are few: hits are told apart by them.
const FEW: usize = 8;

/// Which category a share falls on.
pub(super) fn category(shares: &[f64], share: f64) -> usize {
    let mut sum = 0.0;
    let found = shares.iter().position(|one| {
        sum += one;
        *one > 0.0 && sum > share
    });
    // Rounding may leave a hair beyond the last.
    found.or_else(|| shares.iter().rposition(|one| *one > 0.0)).unwrap_or(0)
}

/// Above 0 and below 1, as coordinates are, however far out.
fn within(share: f64) -> f64 {
    share.clamp(f64::MIN_POSITIVE, 1.0 - f64::EPSILON / 2.0)
}
