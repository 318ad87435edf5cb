//! What a controller looks at on the road, so that a scenario can be warned of what its controller is blind to.

use super::Settings;

/// What a controller looks at, apart from signals, see [`SignalConduct`](super::SignalConduct). Each entry of the registry declares its
/// own.
#[derive(Debug, Clone, Copy)]
pub enum Attention {
    /// It keeps to a speed or a script, whatever is around it.
    Scripted,
    /// It reacts to what it looks at, which may depend on its settings.
    Reacts(fn(&Settings) -> LooksAt),
    /// It gets everything around it and decides by itself.
    Own,
}

/// What a controller that reacts looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LooksAt {
    /// People whose way leads across its lane.
    pub people_crossing: bool,
    /// People who walk along its lane.
    pub people_along: bool,
    /// Vehicles ahead of it in its lane.
    pub vehicles_ahead: bool,
    /// Vehicles of other roads whose way crosses its own.
    pub other_roads: bool,
}

impl LooksAt {
    /// All that is in its own lane or comes into it on foot.
    pub const OWN_LANE: Self =
        Self { people_crossing: true, people_along: true, vehicles_ahead: true, other_roads: false };
}

impl Attention {
    /// What it looks at with these settings; `None` of what is not warned of.
    pub fn with(self, settings: &Settings) -> Option<LooksAt> {
        match self {
            Self::Reacts(looks_at) => Some(looks_at(settings)),
            Self::Scripted | Self::Own => None,
        }
    }
}
