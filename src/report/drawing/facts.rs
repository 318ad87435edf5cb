//! A sketch in words: what stands beside the picture, and what of it lies outside.

use super::outlook::{Meeting, Outlook, Sight, SightKind};
use scenario::{
    CrossingKind, Dimension, Direction, Ground, MayGo, Road, TrafficSignal, TrafficStream, VehicleSetup,
    World, show,
};
use sim::Solid;

/// A line for the road, each road user, each meeting and each line of sight that something is on.
pub(crate) fn facts(world: &World, outlook: &Outlook) -> Vec<String> {
    let mut lines = vec![road(world)];
    lines.extend(world.other_roads.iter().map(other_road));
    for (index, (setup, car)) in world.vehicles.iter().zip(&outlook.cars).enumerate() {
        match world.streams.iter().find(|stream| stream.vehicles.contains(&index)) {
            Some(one) if one.vehicles[0] == index => lines.push(stream(one, setup)),
            Some(_) => continue,
            None => {}
        }
        let place = -car.motion.travelled;
        let (far, side) = if place >= 0.0 { (place, "before") } else { (-place, "behind") };
        lines.push(format!(
            "{}: starts {far:.1} m {side} {}, {}",
            setup.name,
            match setup.road {
                0 => format!("the crossing in lane {}", setup.lane),
                _ => format!("the junction in lane {} of {}", setup.lane, world.road_of(setup).name),
            },
            speed(car.motion.speed)
        ));
    }
    for (setup, person) in world.pedestrians.iter().zip(&outlook.people) {
        let appears = match person.appears {
            Some(time) => format!("appears at {time:.2} s"),
            None => "never appears while the vehicles keep their speed".to_string(),
        };
        let pace = person.speed.map_or("at a speed that nobody knows before".to_string(), |speed| {
            format!("{speed:.2} m/s without traffic")
        });
        let kind =
            if setup.kind.is_pedestrian() { String::new() } else { format!("{}, ", setup.kind.word()) };
        let waits = match setup.stops.len() {
            0 => "",
            1 => "; waits on a refuge, for which no time is taken here",
            _ => "; waits on refuges, for which no time is taken here",
        };
        let looks = match setup.may_go {
            MayGo::AtOnce => String::new(),
            MayGo::After(time) => format!(", looks for {time} s"),
            MayGo::TimeToArrival { or_after, .. } => format!(", looks for {or_after} s at most"),
        };
        lines.push(format!("{}: {kind}{appears}{looks}, {pace}{waits}", setup.name));
    }
    lines.push("If all keep their speed:".to_string());
    let waits = world.vehicles.iter().any(|car| car.obeys_signals)
        || world.pedestrians.iter().any(|person| person.obeys_signals);
    if waits {
        lines.push("  whoever has to wait at the signal is there later than that".to_string());
    }
    if outlook.meetings.is_empty() {
        lines.push("  no two courses meet".to_string());
    }
    let nearest = |met: &&Meeting| {
        met.touches() || !is_of_stream(world, met.vehicle) || {
            let alike = outlook.meetings.iter().filter(|other| other.is_alike(met, world));
            alike.into_iter().all(|other| met.apart() <= other.apart())
        }
    };
    for met in outlook.meetings.iter().filter(nearest) {
        let (one, other) = (&world.vehicles[met.vehicle].name, met.with.name(world));
        let (first, second) = met.times;
        let place = format!("({:.1}, {:.1}) m", met.point.x, met.point.y);
        lines.push(match met.with {
            Solid::Vehicle(before) if world.vehicles[before].road == world.vehicles[met.vehicle].road => {
                format!("  {one} runs into {other} at {place} after {first:.2} s")
            }
            _ if met.touches() => format!(
                "  {one} and {other} meet at {place}: {one} is there after {first:.2} s, {other} after {second:.2} s; their bodies touch"
            ),
            _ => {
                let gap = met.apart();
                let who = if first < second { one.as_str() } else { other };
                format!(
                    "  {one} and {other} pass at {place}: {one} is there after {first:.2} s, {other} after {second:.2} s; {who} is {gap:.2} s earlier"
                )
            }
        });
    }
    // Who drives behind others of a stream sees little beside them.
    let is_told = |sight: &&Sight| {
        !sight.hidden_by.is_empty()
            && !sight.hidden_by.iter().all(|by| are_one_stream(world, sight.vehicle, *by))
    };
    lines.extend(outlook.sights.iter().filter(is_told).map(|one| sight(world, one)));
    lines
}

/// Whether a vehicle is one of a stream.
fn is_of_stream(world: &World, vehicle: usize) -> bool {
    world.streams.iter().any(|stream| stream.vehicles.contains(&vehicle))
}

/// Whether a vehicle and something else are vehicles of one stream.
fn are_one_stream(world: &World, vehicle: usize, other: Solid) -> bool {
    let Solid::Vehicle(other) = other else { return false };
    world.streams.iter().any(|stream| stream.vehicles.contains(&vehicle) && stream.vehicles.contains(&other))
}

/// So many gaps of a stream are told.
const TOLD_GAPS: usize = 8;

/// A stream, of which the first vehicle is told by itself.
fn stream(stream: &TrafficStream, first: &VehicleSetup) -> String {
    let gaps = stream.arrivals.windows(2).map(|pair| show(tidy(pair[1] - pair[0]), None, Dimension::TIME));
    let mut gaps: Vec<String> = gaps.collect();
    if gaps.len() > TOLD_GAPS {
        gaps.truncate(TOLD_GAPS);
        gaps.push("…".to_string());
    }
    let (name, lane) = (&stream.name, first.lane);
    match gaps.is_empty() {
        true => format!("{name}: a stream of one vehicle in lane {lane}"),
        false => format!(
            "{name}: a stream of {} vehicles in lane {lane}, {} apart",
            stream.vehicles.len(),
            gaps.join(", ")
        ),
    }
}

/// A difference of two times (s) without what rounding did to it.
fn tidy(time: f64) -> f64 {
    (time * 1e9).round() / 1e9
}

fn road(world: &World) -> String {
    let road = &world.road;
    let crossings = road.crossings().map(|(along, crossing)| {
        let kind = match crossing.kind {
            CrossingKind::Zebra => "zebra".to_string(),
            CrossingKind::Unmarked => "crossing without marks".to_string(),
            CrossingKind::Signalised(signal) => signalised(world, &signal),
        };
        let place = if along == 0.0 { String::new() } else { format!(" at {along:.1} m") };
        format!("{kind} of {:.1} m{place}", crossing.width)
    });
    let crossings: Vec<_> = crossings.collect();
    let medians = road.medians.iter().map(|median| {
        let kind = if median.refuge { "refuge" } else { "median" };
        format!("; {kind} of {:.1} m after lane {}", median.width, median.after)
    });
    let lanes = road.lanes.iter().map(|lane| direction(lane.direction));
    let lanes: Vec<_> = lanes.collect();
    let shape = match &road.bend {
        None => "straight road".to_string(),
        Some(bend) => format!("bent road of {:.1} m", bend.line.length()),
    };
    format!(
        "{shape}{}, lanes of {:.2} m from near to far: {}{}; {}",
        ground(&road.ground),
        road.lane_width,
        lanes.join(", "),
        medians.collect::<String>(),
        crossings.join("; ")
    )
}

/// A road that lies over that of the world.
fn other_road(road: &Road) -> String {
    let (place, angle) = road.bend.as_ref().map_or((Default::default(), 0.0), |bend| {
        let pose = bend.line.pose(bend.crossing);
        (pose.point, pose.heading)
    });
    let lanes: Vec<_> = road.lanes.iter().map(|lane| direction(lane.direction)).collect();
    format!(
        "{} lies over it, meets it at ({:.1}, {:.1}) m at {:.0}° to x, lanes of {:.2} m from near to far: {}",
        road.name,
        place.x,
        place.y,
        angle.to_degrees(),
        road.lane_width,
        lanes.join(", ")
    )
}

fn direction(direction: Direction) -> &'static str {
    match direction {
        Direction::Forward => "forward",
        Direction::Backward => "backward",
    }
}

/// A signal, and who does not mind it.
fn signalised(world: &World, signal: &TrafficSignal) -> String {
    let cars = world.vehicles.iter().map(|car| (&car.name, car.obeys_signals));
    let people = world.pedestrians.iter().map(|person| (&person.name, person.obeys_signals));
    let ignoring: Vec<&str> =
        cars.chain(people).filter(|(_, obeys)| !obeys).map(|(name, _)| name.as_str()).collect();
    let ignored = match ignoring.is_empty() {
        true => "obeyed by all".to_string(),
        false => format!("not obeyed by {}", ignoring.join(", ")),
    };
    let seconds = |time: f64| show(time, None, Dimension::TIME);
    format!(
        "crossing with a signal (people's green from {} for {} of {}, amber {}, clearance {}; {ignored})",
        seconds(signal.pedestrian_green_from),
        seconds(signal.pedestrian_green),
        seconds(signal.cycle),
        seconds(signal.amber),
        seconds(signal.clearance),
    )
}

fn ground(ground: &Ground) -> String {
    let gradient = ground.gradient.filter(|gradient| *gradient != 0.0).map(|gradient| {
        let way = if gradient < 0.0 { "falls" } else { "rises" };
        format!(" that {way} by {:.1} % along lane 0", 100.0 * gradient.abs())
    });
    let friction = ground.friction.map(|friction| format!(", friction {friction:.2}"));
    [gradient, friction].into_iter().flatten().collect()
}

fn sight(world: &World, sight: &Sight) -> String {
    let (car, person) = (&world.vehicles[sight.vehicle], &world.pedestrians[sight.pedestrian].name);
    let boxes: Vec<&str> = sight.hidden_by.iter().map(|one| one.name(world)).collect();
    let boxes =
        if boxes.iter().all(|name| name.is_empty()) { "a box".to_string() } else { boxes.join(" and ") };
    let until = match sight.clear_from {
        Some(time) => format!("until {time:.2} s"),
        None => "until they meet".to_string(),
    };
    let hidden = format!("{person} appears behind {boxes}, seen from {}, {until}", car.name);
    match sight.kind {
        SightKind::Blocked => hidden,
        SightKind::Through => format!("{hidden}; {}", looks_through(car)),
    }
}

fn looks_through(car: &VehicleSetup) -> String {
    match &car.sees {
        None => format!("{} has no `sees` and looks through it", car.name),
        Some(_) => format!("{} sees without occlusion and looks through it", car.name),
    }
}

fn speed(speed: f64) -> String {
    format!("{:.1} km/h", speed * 3.6)
}
