//! What metrics mean in a scenario with streams.

use std::sync::Arc;

use super::metric::{Cast, metric_reference};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Sources;
use crate::syntax::Tree;
use crate::syntax::ast::{self, View};
use crate::value::NameScope;
use crate::write::write_comparison;
use models::standard;
use scenario::{Comparison, MetricReference, Relation, Scope, Stake, WhenUndefined};

/// What a metric is read as where `cars` is a stream of three and `av` another vehicle, and what is found wrong.
fn read(metric: &str) -> (Option<MetricReference>, Vec<Diagnostic>) {
    let text = format!("scenario a {{\n  expect {{ {metric} = 1 }}\n}}\n");
    let (tree, wrong) = Tree::parse(Sources::default().add("a.scn", text.as_str()), Arc::from(text.as_str()));
    assert!(wrong.is_empty(), "{wrong:?}");
    let node = tree.nodes().find_map(ast::Metric::cast).expect("the text has a metric");
    let registry = standard();
    let cast = Cast {
        vehicles: vec!["av", "cars_1", "cars_2", "cars_3"],
        streams: vec!["cars"],
        pedestrians: vec!["walker", "child"],
        groups: Vec::new(),
        boxes: vec!["parked"],
        individuals: None,
        are_drawn: false,
        metrics: registry.metrics(),
    };
    let mut report = Vec::new();
    let found = metric_reference(node, &cast, &NameScope::default(), &mut report);
    (found.map(|(reference, _)| reference), report)
}

#[test]
fn a_stream_stands_for_its_vehicles_and_for_itself() {
    for (text, of_stream) in [
        ("gap_taken(cars, walker)", true),
        ("gaps_missed(cars, walker)", true),
        ("collision(cars, walker)", true),
        ("collision(cars)", true),
        ("min_ttc(cars, walker)", true),
        ("max_deceleration(cars)", true),
        ("pet(cars, walker)", true),
        ("tta_at_entry(cars, walker)", true),
        ("pet(cars_3, walker)", false),
        ("gap_accepted(cars_3, walker)", false),
        ("gap_accepted(av, walker)", false),
        ("time_left_on_leaving(walker, lane: 1)", false),
        ("step_back(walker)", false),
    ] {
        let (found, report) = read(text);
        let Some(found) = found else { panic!("{text}: {report:?}") };
        assert_eq!(found.of_stream, of_stream, "{text}");
        assert_eq!(found.is_of_vehicle("cars_2"), of_stream, "{text}");
        // What is written is read as the same.
        let when_undefined = WhenUndefined::AsDeclared;
        let comparison = Comparison {
            metric: found.clone(),
            relation: Relation::Equal,
            bound: 1.0.into(),
            when_undefined,
        };
        let written = write_comparison(&comparison);
        assert!(written.starts_with(text), "{written}");
    }
    let several = read("collision(cars, walker, child)").0.unwrap();
    assert_eq!((several.several.len(), several.stream()), (2, Some("cars")));
}

#[test]
fn whoever_asks_who_goes_first_among_many_is_told_to_name_one() {
    let registry = standard();
    let ordered = registry.metrics().iter().filter(|metric| metric.tells_order());
    let ordered: Vec<_> = ordered.map(|metric| &*metric.declaration.name).collect();
    assert_eq!(ordered, ["pet", "pet_area", "passed_first", "gap_accepted", "tta_at_entry"]);
    for metric in registry.metrics().iter() {
        let name = &metric.declaration.name;
        let (found, report) = read(name);
        if !metric.tells_order() {
            assert!(found.is_some(), "{name}: {report:?}");
            continue;
        }
        let [refusal] = report.as_slice() else { panic!("{name}: {report:?}") };
        assert_eq!((refusal.code, found.is_none()), (Code::NoSingleOrder, true), "{name}");
        let hint = refusal.hints.join("\n");
        assert!(hint.contains("gap_taken(cars, walker)"), "{hint}");
        assert!(hint.contains(&format!("{name}(cars_3, walker)")), "{hint}");
        assert_eq!(hint.contains(&format!("{name}(cars, walker)")), metric.stake != Stake::Order, "{hint}");
        // The smallest time to any vehicle is one, but of many there is no order.
        let (found, report) = read(&format!("{name}(cars, child)"));
        assert_eq!(found.is_some(), metric.stake != Stake::Order, "{name}: {report:?}");
        assert_eq!(
            report.first().is_some_and(|one| one.code == Code::NoSingleOrder),
            found.is_none(),
            "{name}"
        );
    }
}

#[test]
fn what_is_of_single_vehicles_or_of_streams_takes_nothing_else() {
    for text in [
        "vehicle_ttc(av, cars)",
        "vehicle_pet(cars, av)",
        "collision(av, cars)",
        "collision(cars, parked)",
        "gap_taken(av, walker)",
        "gap_taken(carts, walker)",
        "gap_taken(cars)",
        "gap_taken(walker)",
    ] {
        let (found, report) = read(text);
        assert!(found.is_none(), "{text}");
        assert_eq!(
            report.iter().map(|one| one.code).collect::<Vec<_>>(),
            [Code::BadPair],
            "{text}: {report:?}"
        );
    }
    assert_eq!(read("gap_taken(cars, nobody)").1[0].code, Code::UnknownPedestrian);
    let streams = standard();
    let of_streams = streams.metrics().iter().filter(|metric| metric.scope == Scope::Stream);
    assert!(
        of_streams.clone().count() == 3 && of_streams.into_iter().all(|metric| metric.declaration.on_request)
    );
}
