//! Physical dimensions as exponents of length, time and angle.

use serde::{Deserialize, Serialize};

/// The dimension of a quantity: powers of metre, second and radian. Shares (%) and plain numbers are dimensionless.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Dimension {
    /// Exponent of the metre.
    pub length: i8,
    /// Exponent of the second.
    pub time: i8,
    /// Exponent of the radian.
    pub angle: i8,
}

impl Dimension {
    /// Plain numbers and shares.
    pub const NUMBER: Self = Self::new(0, 0, 0);
    /// m
    pub const LENGTH: Self = Self::new(1, 0, 0);
    /// s
    pub const TIME: Self = Self::new(0, 1, 0);
    /// m/s
    pub const SPEED: Self = Self::new(1, -1, 0);
    /// m/s²
    pub const ACCELERATION: Self = Self::new(1, -2, 0);
    /// m/s³
    pub const JERK: Self = Self::new(1, -3, 0);
    /// rad
    pub const ANGLE: Self = Self::new(0, 0, 1);
    /// rad/s
    pub const ANGULAR_SPEED: Self = Self::new(0, -1, 1);
    /// 1/s
    pub const FREQUENCY: Self = Self::new(0, -1, 0);
    /// 1/m
    pub const PER_LENGTH: Self = Self::new(-1, 0, 0);
    /// 1/s, as the frequency is.
    pub const PER_TIME: Self = Self::FREQUENCY;

    /// From the exponents of metre, second and radian.
    pub const fn new(length: i8, time: i8, angle: i8) -> Self {
        Self { length, time, angle }
    }

    /// The dimension of a product; `None` when an exponent leaves the range of `i8`.
    pub fn times(self, other: Self) -> Option<Self> {
        Some(Self {
            length: self.length.checked_add(other.length)?,
            time: self.time.checked_add(other.time)?,
            angle: self.angle.checked_add(other.angle)?,
        })
    }

    /// The dimension of a quotient; `None` when an exponent leaves the range of `i8`.
    pub fn over(self, other: Self) -> Option<Self> {
        Some(Self {
            length: self.length.checked_sub(other.length)?,
            time: self.time.checked_sub(other.time)?,
            angle: self.angle.checked_sub(other.angle)?,
        })
    }

    /// What the field calls it, such as `speed`; a general phrase for dimensions without a name.
    pub fn name(self) -> &'static str {
        match self {
            Self::NUMBER => "plain number",
            Self::LENGTH => "length",
            Self::TIME => "time",
            Self::SPEED => "speed",
            Self::ACCELERATION => "acceleration",
            Self::JERK => "jerk",
            Self::ANGLE => "angle",
            Self::ANGULAR_SPEED => "angular speed",
            Self::FREQUENCY => "frequency",
            Self::PER_LENGTH => "inverse length",
            _ => "compound quantity",
        }
    }

    /// The coherent SI unit, such as `m/s^2`; empty for plain numbers.
    pub fn si_unit(self) -> String {
        let part = |symbol: &str, power: i8| match power {
            1 => symbol.to_string(),
            _ => format!("{symbol}^{power}"),
        };
        let bases = [("m", self.length), ("rad", self.angle), ("s", self.time)];
        let join = |sign: i8| {
            bases
                .iter()
                .filter(|(_, power)| power.signum() == sign)
                .map(|&(symbol, power)| part(symbol, power.saturating_mul(sign)))
                .collect::<Vec<_>>()
                .join("*")
        };
        match (join(1), join(-1)) {
            (above, below) if below.is_empty() => above,
            (above, below) if above.is_empty() => format!("1/{below}"),
            (above, below) => format!("{above}/{below}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn si_units_read_as_written() {
        assert_eq!(Dimension::NUMBER.si_unit(), "");
        assert_eq!(Dimension::SPEED.si_unit(), "m/s");
        assert_eq!(Dimension::ACCELERATION.si_unit(), "m/s^2");
        assert_eq!(Dimension::FREQUENCY.si_unit(), "1/s");
        assert_eq!(Dimension::ANGULAR_SPEED.si_unit(), "rad/s");
    }

    #[test]
    fn products_and_quotients_add_and_subtract_exponents() {
        assert_eq!(Dimension::SPEED.times(Dimension::TIME), Some(Dimension::LENGTH));
        assert_eq!(Dimension::LENGTH.over(Dimension::TIME), Some(Dimension::SPEED));
        assert_eq!(Dimension::new(127, 0, 0).times(Dimension::LENGTH), None);
    }
}
