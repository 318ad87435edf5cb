//! Where a scenario lies in the plane: the road as its path leads, and where people start and walk to.

use std::sync::Arc;

use super::check::{check_number, check_places, starts_beyond};
use super::error::PlanError;
use super::variables::{Variables, number};
use scenario::geometry::{CurvedPath, GeometryError, Piece, Pose, ReferenceLine};
use scenario::limits::{self, Limit};
use scenario::{
    Bend, BendRadius, Crossing, CrossingKind, DeclaredAppearance, DeclaredGround, DeclaredPedestrian,
    DeclaredPiece, Dimension, Direction, Expression, Ground, Origin, Path, PieceKind, Position, Road,
    Scenario, Side, SignalError, show,
};

/// The road of a scenario where variations have these values.
///
/// # Errors
/// A gradient or friction out of its range; a path with a number out of its range, one too tight for its lanes, one that comes back to
/// itself, and a crossing that is not on it.
pub(super) fn road(scenario: &Scenario, variables: &Variables) -> Result<Road, PlanError> {
    let ground = ground(scenario, (scenario.ground.as_ref(), "road"), variables)?;
    let mut own = Road { ground, crossing: crossing(scenario, variables)?, ..scenario.road.clone() };
    let Some(declared) = &scenario.bend else {
        place_crossings(scenario, variables, &mut own, None)?;
        return Ok(own);
    };
    let path = (declared.pieces.as_slice(), "road", &declared.origin);
    let line = line(scenario, &scenario.road, path, variables)?;
    let crossing = number(&declared.crossing, variables, &declared.origin)?;
    let what = "the place of the crossing on its path";
    check_number(scenario, "road.at", what, crossing, limits::STATION, &declared.origin)?;
    if crossing > line.length() {
        let message =
            format!("the crossing is {} behind the end of the path", metres(crossing - line.length()));
        let hint =
            format!("the path is {} long: let `at` be less, or the path longer", metres(line.length()));
        return Err(PlanError::new(&declared.origin, message).with_hint(hint));
    }
    let length = line.length();
    let bend = Some(Bend { line: Arc::new(line), crossing });
    let mut road = Road { bend, ..own };
    place_crossings(scenario, variables, &mut road, Some((crossing, length)))?;
    refuse_return(&road, &declared.origin)?;
    let boxes = std::mem::take(&mut road.boxes);
    road.boxes = boxes.into_iter().map(|body| road.turned_body(body)).collect();
    Ok(road)
}

/// Puts the other crossings of a road where the scenario says that they are: on a path, of which the station of the first crossing and
/// the length are given (m), behind its beginning.
fn place_crossings(
    scenario: &Scenario,
    variables: &Variables,
    road: &mut Road,
    path: Option<(f64, f64)>,
) -> Result<(), PlanError> {
    for (index, declared) in scenario.other_crossings.iter().enumerate() {
        let at = number(&declared.at, variables, &declared.origin)?;
        let name = road.other_crossings[index].name.clone();
        let what = format!("the place of crossing `{name}`");
        let said = format!("road.{name}.at");
        let limit = if path.is_some() { limits::STATION } else { limits::CROSSING_PLACE };
        check_number(scenario, &said, &what, at, limit, &declared.origin)?;
        if let Some((_, length)) = path.filter(|(_, length)| at > *length) {
            let message = format!("crossing `{name}` is {} behind the end of the path", metres(at - length));
            let hint = format!("the path is {} long: let `at` be less, or the path longer", metres(length));
            return Err(PlanError::new(&declared.origin, message).with_hint(hint));
        }
        road.other_crossings[index].along = at - path.map_or(0.0, |(first, _)| first);
    }
    let crossings: Vec<_> = road.crossings().collect();
    for (index, declared) in scenario.other_crossings.iter().enumerate() {
        let (along, crossing) = crossings[index + 1];
        let other = crossings[..=index].iter().position(|(other_along, other)| {
            (along - other_along).abs() < (crossing.width + other.width) / 2.0
        });
        if let Some(other) = other {
            let called = |number: usize| match number.checked_sub(1) {
                None => "the first crossing".to_string(),
                Some(other) => format!("crossing `{}`", road.other_crossings[other].name),
            };
            let message = format!("{} lies on {}", called(index + 1), called(other));
            let apart = metres((crossing.width + crossings[other].1.width) / 2.0);
            let hint = format!("their middles have to be at least {apart} apart");
            return Err(PlanError::new(&declared.origin, message).with_hint(hint));
        }
    }
    Ok(())
}

/// The number of the crossing that somebody uses, and where on the road that is, m.
///
/// # Errors
/// A crossing that the road does not have.
pub(super) fn crossing_used(road: &Road, declared: &DeclaredPedestrian) -> Result<(usize, f64), PlanError> {
    let Some(name) = &declared.crosses else { return Ok((0, 0.0)) };
    let found = road.other_crossings.iter().position(|other| other.name == *name);
    found
        .map(|index| (index + 1, road.other_crossings[index].along))
        .ok_or_else(|| PlanError::new(&declared.origin, format!("the road has no crossing called `{name}`")))
}

/// The middles of the refuges on which somebody waits.
///
/// # Errors
/// If they are to wait and there is none on their way.
pub(super) fn stops(
    road: &Road,
    declared: &DeclaredPedestrian,
    (start, goal): (Position, Position),
) -> Result<Vec<Position>, PlanError> {
    if !declared.waits_on_refuges {
        return Ok(Vec::new());
    }
    let stops = road.refuges_between(start, goal);
    if stops.is_empty() {
        let (name, kind) = (&declared.name, declared.kind.word());
        let message = format!("{kind} `{name}` waits on refuges, and there is none on its way");
        let hint = "give the road one between two lanes: `median 2 m after lane 0 with refuge`";
        return Err(PlanError::new(&declared.origin, message).with_hint(hint));
    }
    Ok(stops)
}

/// The crossing, of whose signal something may vary.
fn crossing(scenario: &Scenario, variables: &Variables) -> Result<Crossing, PlanError> {
    let mut found = scenario.road.crossing.clone();
    let (Some(declared), CrossingKind::Signalised(signal)) = (&scenario.signal, &mut found.kind) else {
        return Ok(found);
    };
    for (name, value) in &declared.varied {
        let value = number(value, variables, &declared.origin)?;
        let limit = limits::of_signal(name);
        let what = format!("`{name}` of the signal");
        check_number(scenario, &format!("road.{name}"), &what, value, limit, &declared.origin)?;
        if let Some(number) = signal.number_mut(name) {
            *number = value;
        }
    }
    let refused = |error: SignalError| PlanError::new(&declared.origin, error.message).with_hint(error.hint);
    signal.check().map_err(refused)?;
    Ok(found)
}

pub(super) fn ground(
    scenario: &Scenario,
    (declared, road): (Option<&DeclaredGround>, &str),
    variables: &Variables,
) -> Result<Ground, PlanError> {
    let Some(declared) = declared else { return Ok(Ground::default()) };
    let found = |name: &str, value: &Option<Expression>, limit: Limit| {
        let Some(value) = value else { return Ok(None) };
        let found = number(value, variables, &declared.origin)?;
        let what = format!("the {name} of the road");
        check_number(scenario, &format!("{road}.{name}"), &what, found, limit, &declared.origin)?;
        Ok(Some(found))
    };
    Ok(Ground {
        gradient: found("gradient", &declared.gradient, limits::GRADIENT)?,
        friction: found("friction", &declared.friction, limits::FRICTION)?,
    })
}

pub(super) fn metres(length: f64) -> String {
    show(length, None, Dimension::LENGTH)
}

/// The line that the pieces of a road's path make, along x from the origin; what it says is known by the road's `name`.
pub(super) fn line(
    scenario: &Scenario,
    road: &Road,
    (declared, name, own): (&[DeclaredPiece], &str, &Origin),
    variables: &Variables,
) -> Result<ReferenceLine, PlanError> {
    let mut pieces: Vec<Piece> = Vec::new();
    // Which statement each comes from.
    let mut statements: Vec<&Origin> = Vec::new();
    for (index, said) in declared.iter().enumerate() {
        check_piece(scenario, &format!("{name}.path.{}", index + 1), &said.kind, variables, &said.origin)?;
        let before = pieces.last().map_or(0.0, |piece| piece.to);
        let made = said.kind.pieces(before, |value| number(value, variables, &said.origin))?;
        statements.extend(std::iter::repeat_n(&said.origin, made.len()));
        pieces.extend(made);
    }
    let at = |piece: usize| statements.get(piece - 1).copied().unwrap_or(own);
    let wrong = |error: GeometryError| match error {
        GeometryError::Length { piece, .. } | GeometryError::NotFinite { piece } => {
            PlanError::new(at(piece), error.to_string())
        }
        _ => PlanError::new(own, error.to_string()),
    };
    let line = ReferenceLine::new(Pose::origin(), &pieces).map_err(wrong)?;
    let line = Arc::new(line);
    for side in [Side::Near, Side::Far] {
        let kerb = road.kerb(side);
        let made = CurvedPath::new(line.clone(), kerb, Direction::Forward, 0.0);
        if let Err(GeometryError::TooTight { piece, radius, least, .. }) = made {
            let message = format!(
                "this bends with a radius of {}, too tight for a road that reaches {} to a side of the centre of lane 0",
                metres(radius),
                metres(kerb.abs())
            );
            let hint = format!("let the radius be above {}, or the road be narrower", metres(least));
            return Err(PlanError::new(at(piece), message).with_hint(hint));
        }
    }
    Ok(Arc::unwrap_or_clone(line))
}

/// Whether the numbers of a piece are in their ranges.
fn check_piece(
    scenario: &Scenario,
    name: &str,
    kind: &PieceKind,
    variables: &Variables,
    origin: &Origin,
) -> Result<(), PlanError> {
    let check = |part: &str, what: &str, value: &Expression, limit: Limit| {
        let found = number(value, variables, origin)?;
        check_number(scenario, &format!("{name}.{part}"), what, found, limit, origin)
    };
    let bends = |about: &Option<BendRadius>| {
        let radius = about
            .as_ref()
            .map(|about| check("radius", "the radius of a bend", &about.radius, limits::BEND_RADIUS));
        radius.unwrap_or(Ok(()))
    };
    match kind {
        PieceKind::Straight { length } => {
            check("length", "the length of a straight line", length, limits::PIECE)
        }
        PieceKind::Clothoid { length, to } => {
            check("length", "the length of a clothoid", length, limits::PIECE)?;
            bends(to)
        }
        PieceKind::Arc { angle, about } => {
            check("arc", "the angle of an arc", angle, limits::BEND_ANGLE)?;
            bends(about)
        }
        PieceKind::Turn { is_left: _, radius, clothoid, arc } => {
            check("radius", "`radius` of `turn`", radius, limits::BEND_RADIUS)?;
            check("clothoid", "`clothoid` of `turn`", clothoid, limits::BEND_ANGLE)?;
            check("arc", "`arc` of `turn`", arc, limits::BEND_ANGLE)
        }
    }
}

/// A road that comes back to itself would be two roads at one place: nobody could say which of them somebody crosses.
pub(super) fn refuse_return(road: &Road, origin: &Origin) -> Result<(), PlanError> {
    let Some((one, other)) = road.comes_back() else { return Ok(()) };
    let message = format!(
        "the road comes back to itself: what is {} behind its beginning lies on what is {} behind it",
        metres(other.round()),
        metres(one.round())
    );
    Err(PlanError::new(origin, message).with_hint(
        "let its path turn less, or be longer between two turns; beyond its ends a road goes straight on",
    ))
}

/// Where somebody starts and where they walk to, and the course that they follow who walk along the lane of a road that bends.
///
/// # Errors
/// A number out of its range, and a start beyond the goal.
pub(super) fn way(
    scenario: &Scenario,
    road: &Road,
    declared: &DeclaredPedestrian,
    variables: &Variables,
) -> Result<(Position, Position, Option<Path>), PlanError> {
    let number = |expression: &Expression| number(expression, variables, &declared.origin);
    let (side, sign) = (declared.side, declared.side.walking_sign());
    let (said, start) = (number(&declared.along)?, number(&declared.start_from_lane_centre)?);
    // At the first crossing, with the bits that this always had.
    let along =
        crossing_used(road, declared).map(|(number, at)| if number == 0 { said } else { at + said })?;
    let goal = number(&declared.goal_beyond_kerb)?;
    if let Some(walks) = &declared.walks {
        let further = number(&walks.further)?;
        return way_along(scenario, road, declared, (start, (along, said), further), walks.with_traffic);
    }
    let from = road.outer_lane_centre(side) - sign * start;
    let to = road.kerb(side.opposite()) + sign * goal;
    let turned = number(&declared.turned)?;
    if road.bend.is_none() && turned == 0.0 {
        return Ok((Position { x: along, y: from }, Position { x: along, y: to }, None));
    }
    check_places(scenario, declared, (start, said, goal), turned)?;
    if sign * (to - from) <= 0.0 {
        return Err(starts_beyond(scenario, declared));
    }
    let (start, goal) = road.way(side, along, (from, to), turned);
    Ok((start, goal, None))
}

/// Where somebody starts and where they walk to who walks along the lane that is outermost on their side, in a bend along its course.
fn way_along(
    scenario: &Scenario,
    road: &Road,
    declared: &DeclaredPedestrian,
    (start, (along, said), further): (f64, (f64, f64), f64),
    with_traffic: bool,
) -> Result<(Position, Position, Option<Path>), PlanError> {
    let (name, kind) = (&declared.name, declared.kind.word());
    check_places(scenario, declared, (start, said, 0.0), 0.0)?;
    let what = format!("the goal of {kind} `{name}`");
    check_number(scenario, &format!("{name}.goal"), &what, further, limits::FURTHER, &declared.origin)?;
    let sign = declared.side.walking_sign();
    let lane = match declared.side {
        Side::Near => 0,
        Side::Far => road.lanes.len() - 1,
    };
    // Who is to meet a vehicle is put beside its lane's centre later.
    let is_met = matches!(declared.appears, DeclaredAppearance::Meets { .. }) && road.bend.is_some();
    let y = road.outer_lane_centre(declared.side) - if is_met { 0.0 } else { sign * start };
    let direction = match (road.lanes[lane].direction, with_traffic) {
        (direction, true) => direction,
        (Direction::Forward, false) => Direction::Backward,
        (Direction::Backward, false) => Direction::Forward,
    };
    if let Some(bend) = &road.bend {
        return course_beside(bend, (declared, &declared.origin), (y, direction), (along, further));
    }
    let ahead = Path::straight(y, direction).heading(0.0).x;
    Ok((Position { x: along, y }, Position { x: along + ahead * further, y }, None))
}

/// Where somebody starts and where they walk to who walks along a bend, `y` m to the left of its line: from abreast of `along` m on so much further.
pub(super) fn course_beside(
    bend: &Bend,
    (declared, said): (&DeclaredPedestrian, &Origin),
    (y, direction): (f64, Direction),
    (along, further): (f64, f64),
) -> Result<(Position, Position, Option<Path>), PlanError> {
    let course = CurvedPath::new(bend.line.clone(), y, direction, bend.crossing).map_err(|error| {
        let (name, kind) = (&declared.name, declared.kind.word());
        let message = format!("{kind} `{name}` walks along a bend that is too tight for it: {error}");
        PlanError::new(said, message)
            .with_hint("let it start nearer to the lane's centre, or take a wider bend")
    })?;
    let path = Path::curved(course);
    let from = path.at_line(along);
    let at = |place: f64| {
        let point = path.point(place);
        Position { x: point.x, y: point.y }
    };
    let (start, goal) = (at(from), at(from + further));
    Ok((start, goal, Some(path)))
}
