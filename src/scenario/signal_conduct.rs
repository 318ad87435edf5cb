//! What a model does about the signal of a crossing, and what a scenario may say of it.

use super::traffic_signal::SignalError;

/// What a model or controller does about the signal of a crossing. Each entry of the registry declares its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SignalConduct {
    /// It stops for red, unless a scenario says `ignores signals`.
    Obeys,
    /// It goes, unless a scenario says `obeys signals`.
    Ignores,
    /// It looks at nothing that a signal could show, so that a scenario cannot say `obeys signals`.
    Never {
        /// What to do instead.
        cure: &'static str,
    },
    /// It is told what the signal shows and decides by itself: a scenario can say neither.
    Own,
}

impl SignalConduct {
    /// Whether a model called `name` stops for red where a scenario says so much of it.
    ///
    /// # Errors
    /// Where it can do no such thing.
    pub fn obeys(self, said: Option<bool>, name: &str) -> Result<bool, SignalError> {
        let error = |message: String, hint: String| Err(SignalError { message, hint });
        match (self, said) {
            (Self::Obeys | Self::Ignores, Some(said)) => Ok(said),
            (Self::Obeys, None) => Ok(true),
            (Self::Ignores, None) | (Self::Never { .. } | Self::Own, None) => Ok(false),
            (Self::Never { .. }, Some(false)) => Ok(false),
            (Self::Never { cure }, Some(true)) => {
                error(format!("`{name}` looks at no signals, so that it cannot obey them"), cure.to_string())
            }
            (Self::Own, Some(said)) => {
                let said = if said { "obeys" } else { "ignores" };
                error(
                    format!("`{name}` decides by itself what it does about signals"),
                    format!("leave `{said} signals` out: it is told what the signal shows (`road.signal`)"),
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_scenario_says_counts_where_a_model_can_do_it() {
        let all = [
            SignalConduct::Obeys,
            SignalConduct::Ignores,
            SignalConduct::Never { cure: "take another" },
            SignalConduct::Own,
        ];
        let found = |said| all.map(|conduct| conduct.obeys(said, "it").ok());
        assert_eq!(found(None), [Some(true), Some(false), Some(false), Some(false)]);
        assert_eq!(found(Some(true)), [Some(true), Some(true), None, None]);
        assert_eq!(found(Some(false)), [Some(false), Some(false), Some(false), None]);
    }
}
