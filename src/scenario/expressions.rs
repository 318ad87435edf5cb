//! Every expression of a scenario, in one place: what is evaluated for each case, and what can depend on a variation.

use super::{
    Aggregate, BendRadius, Claim, DeclaredAppearance, DeclaredBend, DeclaredFollowing, DeclaredGround,
    DeclaredMayGo, DeclaredOtherRoad, DeclaredPedestrian, DeclaredPiece, DeclaredShape, DeclaredSignal,
    DeclaredStream, DeclaredVehicleStart, Expression, FurtherGaps, Model, Origin, PieceKind, Vehicle,
    WalksAlong,
};

/// Declares how the expressions of something are gathered, for looking at them and for changing them. Everything is taken apart,
/// so that a field that is new has to be decided about.
macro_rules! expressions {
    ($numbers:ident $($mut:tt)?) => {
        use super::*;

        pub fn vehicle(car: &$($mut)? Vehicle) -> Vec<(&$($mut)? Expression, &Origin)> {
            let Vehicle { name: _, controller, dynamics, size, speed, initial_speed, start, road: _, lane: _, follows, sees, obeys_signals: _, ignores_vehicles: _, origin } = car;
            let mut found = model(controller);
            if let Some(dynamics) = dynamics {
                found.extend(model(dynamics));
            }
            if let Some(sees) = sees {
                found.extend(model(sees));
            }
            let origin: &Origin = origin;
            if let Some((length, width)) = size {
                found.extend([(length, origin), (width, origin)]);
            }
            match start {
                DeclaredVehicleStart::Automatic => {}
                DeclaredVehicleStart::Distance(value) | DeclaredVehicleStart::TimeToArrival(value) => {
                    found.push((value, origin));
                }
                DeclaredVehicleStart::Stream(DeclaredStream { first, gaps, then }) => {
                    found.push((first, origin));
                    for gap in gaps {
                        found.push((gap, origin));
                    }
                    match then {
                        FurtherGaps::None => {}
                        FurtherGaps::Alike(gap) => found.push((gap, origin)),
                        FurtherGaps::Drawn { distribution, chance } => {
                            found.push((chance, origin));
                            for number in distribution.$numbers() {
                                found.push((number, origin));
                            }
                        }
                    }
                }
            }
            if let DeclaredFollowing::Behind(behind) = follows {
                found.push((behind, origin));
            }
            found.push((speed, origin));
            if let Some(initial_speed) = initial_speed {
                found.push((initial_speed, origin));
            }
            found
        }

        pub fn pedestrian(person: &$($mut)? DeclaredPedestrian) -> Vec<(&$($mut)? Expression, &Origin)> {
            let DeclaredPedestrian {
                name: _,
                kind: _,
                model: how,
                shape,
                side: _,
                obeys_signals: _,
                start_from_lane_centre,
                crosses: _,
                waits_on_refuges: _,
                along,
                goal_beyond_kerb,
                turned,
                walks,
                appears,
                may_go,
                may_start_inside: _,
                reference,
                individuals: _,
                group: _,
                origin,
            } = person;
            let mut found = model(how);
            let origin: &Origin = origin;
            match shape {
                None => {}
                Some(DeclaredShape::Disc { radius }) => found.push((radius, origin)),
                Some(DeclaredShape::Rectangle { length, width }) => {
                    found.extend([(length, origin), (width, origin)]);
                }
            }
            if let Some(WalksAlong { with_traffic: _, further }) = walks {
                found.push((further, origin));
            }
            match appears {
                DeclaredAppearance::At(number)
                | DeclaredAppearance::TimeToArrival { vehicle: _, reference: _, time: number } => {
                    found.push((number, origin));
                }
                DeclaredAppearance::Meets { vehicle: _, share, after } => {
                    found.push((share, origin));
                    if let Some(after) = after {
                        found.push((after, origin));
                    }
                }
            }
            match may_go {
                DeclaredMayGo::AtOnce => {}
                DeclaredMayGo::After(time) => found.push((time, origin)),
                DeclaredMayGo::TimeToArrival { vehicle: _, reference: _, time, or_after } => {
                    found.extend([(time, origin), (or_after, origin)]);
                }
            }
            let places = [start_from_lane_centre, along, goal_beyond_kerb, turned, reference];
            found.extend(places.into_iter().map(|place| (place, origin)));
            found
        }

        pub fn bend(bend: &$($mut)? DeclaredBend) -> Vec<(&$($mut)? Expression, &Origin)> {
            let DeclaredBend { pieces, crossing, origin } = bend;
            let origin: &Origin = origin;
            let mut found = vec![(crossing, origin)];
            for piece in pieces {
                found.extend(of_piece(piece));
            }
            found
        }

        pub fn other_road(other: &$($mut)? DeclaredOtherRoad) -> Vec<(&$($mut)? Expression, &Origin)> {
            let DeclaredOtherRoad { road: _, pieces, ground: under, at, meets, angle, origin } = other;
            let origin: &Origin = origin;
            let mut found = vec![(at, origin), (angle, origin)];
            if let Some(meets) = meets {
                found.push((meets, origin));
            }
            for piece in pieces {
                found.extend(of_piece(piece));
            }
            if let Some(under) = under {
                found.extend(ground(under));
            }
            found
        }

        fn of_piece(piece: &$($mut)? DeclaredPiece) -> Vec<(&$($mut)? Expression, &Origin)> {
            let DeclaredPiece { kind, origin } = piece;
            let origin: &Origin = origin;
            let mut found = Vec::new();
            match kind {
                PieceKind::Straight { length } => found.push((length, origin)),
                PieceKind::Clothoid { length, to: about } | PieceKind::Arc { angle: length, about } => {
                    found.push((length, origin));
                    if let Some(BendRadius { radius, is_left: _ }) = about {
                        found.push((radius, origin));
                    }
                }
                PieceKind::Turn { is_left: _, radius, clothoid, arc } => {
                    found.extend([(radius, origin), (clothoid, origin), (arc, origin)]);
                }
            }
            found
        }

        pub fn ground(ground: &$($mut)? DeclaredGround) -> Vec<(&$($mut)? Expression, &Origin)> {
            let DeclaredGround { gradient, friction, origin } = ground;
            let origin: &Origin = origin;
            let mut found = Vec::new();
            if let Some(gradient) = gradient {
                found.push((gradient, origin));
            }
            if let Some(friction) = friction {
                found.push((friction, origin));
            }
            found
        }

        pub fn signal(signal: &$($mut)? DeclaredSignal) -> Vec<(&$($mut)? Expression, &Origin)> {
            let DeclaredSignal { varied, origin } = signal;
            let origin: &Origin = origin;
            let mut found = Vec::new();
            for (_, value) in varied {
                found.push((value, origin));
            }
            found
        }

        fn model<T>(named: &$($mut)? Model<T>) -> Vec<(&$($mut)? Expression, &Origin)> {
            let Model { first: _, varied_by: _, varied: _, others: _, settings, origin } = named;
            let origin: &Origin = origin;
            let mut found = Vec::new();
            for (_, value) in settings {
                found.push((value, origin));
            }
            found
        }

        pub fn claim(claim: &$($mut)? Claim) -> Vec<&$($mut)? Expression> {
            match claim {
                Claim::Runs { comparison, share: _, confidence: _ } => vec![&$($mut)? comparison.bound],
                Claim::Aggregate { aggregate, relation: _, bound, when_undefined: _, confidence: _ } => {
                    match aggregate {
                        Aggregate::Rate(comparison) | Aggregate::Count(comparison) => {
                            vec![&$($mut)? comparison.bound, bound]
                        }
                        _ => vec![bound],
                    }
                }
            }
        }
    };
}

mod shared {
    expressions!(numbers);
}

mod exclusive {
    expressions!(numbers_mut mut);
}

impl Vehicle {
    /// Every expression of it, with the place that gives it.
    pub fn expressions(&self) -> Vec<(&Expression, &Origin)> {
        shared::vehicle(self)
    }

    /// As [`Self::expressions`].
    pub fn expressions_mut(&mut self) -> Vec<(&mut Expression, &Origin)> {
        exclusive::vehicle(self)
    }
}

impl DeclaredPedestrian {
    /// Every expression of it, with the place that gives it.
    pub fn expressions(&self) -> Vec<(&Expression, &Origin)> {
        shared::pedestrian(self)
    }

    /// As [`Self::expressions`].
    pub fn expressions_mut(&mut self) -> Vec<(&mut Expression, &Origin)> {
        exclusive::pedestrian(self)
    }
}

impl DeclaredBend {
    /// Every expression of it, with the place that gives it.
    pub fn expressions(&self) -> Vec<(&Expression, &Origin)> {
        shared::bend(self)
    }

    /// As [`Self::expressions`].
    pub fn expressions_mut(&mut self) -> Vec<(&mut Expression, &Origin)> {
        exclusive::bend(self)
    }
}

impl DeclaredOtherRoad {
    /// Every expression of it, with the place that gives it.
    pub fn expressions(&self) -> Vec<(&Expression, &Origin)> {
        shared::other_road(self)
    }

    /// As [`Self::expressions`].
    pub fn expressions_mut(&mut self) -> Vec<(&mut Expression, &Origin)> {
        exclusive::other_road(self)
    }
}

impl DeclaredGround {
    /// Every expression of it, with the place that gives it.
    pub fn expressions(&self) -> Vec<(&Expression, &Origin)> {
        shared::ground(self)
    }

    /// As [`Self::expressions`].
    pub fn expressions_mut(&mut self) -> Vec<(&mut Expression, &Origin)> {
        exclusive::ground(self)
    }
}

impl DeclaredSignal {
    /// Every expression of it, with the place that gives it.
    pub fn expressions(&self) -> Vec<(&Expression, &Origin)> {
        shared::signal(self)
    }

    /// As [`Self::expressions`].
    pub fn expressions_mut(&mut self) -> Vec<(&mut Expression, &Origin)> {
        exclusive::signal(self)
    }
}

impl Claim {
    /// Everything that it compares to.
    pub fn bounds(&self) -> Vec<&Expression> {
        shared::claim(self)
    }

    /// As [`Self::bounds`].
    pub fn bounds_mut(&mut self) -> Vec<&mut Expression> {
        exclusive::claim(self)
    }
}
