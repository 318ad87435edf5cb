//! The vehicles of a world: those that are declared one by one, and those of streams.

use super::error::PlanError;
use super::variables::Variables;
use scenario::{
    DeclaredVehicleStart, Dimension, Origin, Scenario, TrafficStream, Vehicle, VehicleReference,
    VehicleSetup, VehicleStart, show,
};

/// Who drives in a world, in the order of its vehicles.
pub(super) struct Streams {
    pub driven: Vec<Driven>,
    pub streams: Vec<TrafficStream>,
}

/// A vehicle of a world.
pub(super) struct Driven {
    pub name: String,
    /// Index into [`Scenario::vehicles`] of what declares it.
    pub declared: usize,
    /// Of a vehicle of a stream, when it arrives, s.
    arrival: Option<f64>,
}

/// Who drives where variations and draws have these values.
///
/// # Errors
/// A stream that cannot be what it is declared to be.
pub(super) fn streams(scenario: &Scenario, variables: &Variables) -> Result<Streams, PlanError> {
    let mut found = Streams { driven: Vec::with_capacity(scenario.vehicles.len()), streams: Vec::new() };
    for (declared, car) in scenario.vehicles.iter().enumerate() {
        let DeclaredVehicleStart::Stream(stream) = &car.start else {
            found.driven.push(Driven { name: car.name.clone(), declared, arrival: None });
            continue;
        };
        let arrivals = stream.arrivals(variables, scenario.horizon).map_err(|error| {
            PlanError::new(&car.origin, format!("of stream `{}` {error}", car.name))
                .with_hint("give it longer gaps, or the scenario a shorter `horizon`")
        })?;
        let first = found.driven.len();
        found.driven.extend(arrivals.iter().enumerate().map(|(index, arrival)| Driven {
            name: TrafficStream::member_name(&car.name, index),
            declared,
            arrival: Some(*arrival),
        }));
        let vehicles = (first..found.driven.len()).collect();
        found.streams.push(TrafficStream { name: car.name.clone(), vehicles, arrivals });
    }
    Ok(found)
}

/// The setup of everybody who drives, where `setup` makes that of what is declared.
///
/// # Errors
/// Those of `setup`, and vehicles of a stream that are inside each other.
pub(super) fn vehicles(
    scenario: &Scenario,
    driven: &[Driven],
    setup: impl Fn(&Vehicle) -> Result<VehicleSetup, PlanError>,
) -> Result<Vec<VehicleSetup>, PlanError> {
    let mut found: Vec<VehicleSetup> = Vec::with_capacity(driven.len());
    let mut before: Option<(usize, f64)> = None;
    for driven in driven {
        let declared = &scenario.vehicles[driven.declared];
        let Some(arrival) = driven.arrival else {
            found.push(setup(declared)?);
            continue;
        };
        // Those of one stream differ in nothing but their names and starts.
        let of_stream = before.filter(|(stream, _)| *stream == driven.declared);
        let template = match (of_stream, found.last()) {
            (Some((_, last)), Some(ahead)) => {
                refuse_inside(ahead, arrival - last, declared)?;
                ahead.clone()
            }
            _ => setup(declared)?,
        };
        let start =
            VehicleStart::TimeToArrival { time: arrival, reference: VehicleReference::Centre, x: 0.0 };
        found.push(VehicleSetup { name: driven.name.clone(), start, ..template });
        before = Some((driven.declared, arrival));
    }
    Ok(found)
}

/// # Errors
/// If the vehicle that comes `gap` s after another of its stream would start inside it.
fn refuse_inside(ahead: &VehicleSetup, gap: f64, declared: &Vehicle) -> Result<(), PlanError> {
    let apart = gap * ahead.placing_speed();
    if apart > ahead.length {
        return Ok(());
    }
    let shown = |number: f64, dimension| show(number, None, dimension);
    let message = format!(
        "a gap of {} is {} at {}, and the vehicles of stream `{}` are {} long",
        shown(gap, Dimension::TIME),
        shown(apart, Dimension::LENGTH),
        shown(ahead.placing_speed(), Dimension::SPEED),
        declared.name,
        shown(ahead.length, Dimension::LENGTH),
    );
    Err(PlanError::new(&declared.origin, message).with_hint(
        "give it longer gaps; what is drawn can be cut: `truncated_normal(mean, standard deviation, low, high)`",
    ))
}

/// That a world has no vehicle of that name.
pub(super) fn no_vehicle(name: &str, origin: &Origin) -> PlanError {
    let error = PlanError::new(origin, format!("there is no vehicle called `{name}`"));
    match TrafficStream::of_member(name) {
        Some((stream, _)) => {
            error.with_hint(format!("the stream `{stream}` has fewer vehicles until the horizon"))
        }
        None => error,
    }
}
