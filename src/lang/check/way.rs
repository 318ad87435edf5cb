//! Which statements of a pedestrian go together: those of who walks across the road, and those of who walks along a lane.

use super::block::{Layer, Said, last};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::ast;

/// What is said of where somebody walks, each in the last layer that says it.
pub struct Way<'a> {
    /// `walks with traffic`
    pub walks: Option<Said<'a, ast::Walks<'a>>>,
    /// `goal 2 m beyond kerb` or `goal 40 m further`
    pub goal: Option<Said<'a, ast::Goal<'a>>>,
    start: Option<Said<'a, ast::PedestrianStart<'a>>>,
    turned: Option<Said<'a, ast::Turned<'a>>>,
    meets: Option<Said<'a, ast::Meets<'a>>>,
}

impl<'a> Way<'a> {
    pub fn of(layers: &[Layer<'a, ast::PedestrianBlock<'a>>]) -> Self {
        let meets = last(layers, ast::PedestrianBlock::appearance).and_then(|said| match said.node {
            ast::Appearance::Meets(node) => Some(Said { node, scope: said.scope }),
            ast::Appearance::Appears(_) => None,
        });
        Self {
            walks: last(layers, ast::PedestrianBlock::walks),
            goal: last(layers, ast::PedestrianBlock::goal),
            start: last(layers, ast::PedestrianBlock::start),
            turned: last(layers, ast::PedestrianBlock::turned),
            meets,
        }
    }

    /// Whether it has to be said how far from the lane's centre they start. Who meets a vehicle along a lane starts where they are hit.
    pub fn needs_start(&self) -> bool {
        self.walks.is_none() || self.meets.is_none()
    }

    /// Reports what does not go together; whether all does.
    pub fn check(&self, report: &mut Vec<Diagnostic>) -> bool {
        let before = report.len();
        let mut wrong = |span: Span, message: &str, hint: &str| {
            let label = "does not go together";
            report.push(Diagnostic::new(Code::WrongWay, span, message).label(label).hint(hint));
        };
        let after = self.meets.and_then(|said| said.node.after());
        let Some(walks) = self.walks else {
            if let Some(goal) = self.goal.filter(|goal| goal.node.is_further()) {
                let hint =
                    "say `walks with traffic` or `walks against traffic` as well, or `goal 2 m beyond kerb`";
                wrong(goal.node.span(), "`further` is said of a pedestrian who walks across the road", hint);
            }
            if let Some(after) = after {
                let hint = "who crosses is met where its way leads across the lane: leave `after` away, or say `walks with traffic`";
                wrong(after.span(), "`after` is said of a pedestrian who walks across the road", hint);
            }
            return report.len() == before;
        };
        match self.goal {
            Some(goal) if goal.node.is_further() => {}
            Some(goal) => wrong(
                goal.node.span(),
                "a pedestrian who walks along a lane has a goal beyond the kerb",
                "say how far it walks: `goal 40 m further`",
            ),
            None => wrong(
                walks.node.span(),
                "a pedestrian walks along a lane and nothing says how far",
                "say `goal 40 m further`",
            ),
        }
        if let Some(turned) = self.turned {
            let hint = "leave `turned` or `walks` away";
            wrong(turned.node.span(), "a way along a lane is turned against straight across the road", hint);
        }
        if let Some(meets) = self.meets {
            if after.is_none() {
                let hint = "say after which way it is hit: `meets av at 25 % after 11 m`";
                wrong(meets.node.span(), "a pedestrian along a lane could be met anywhere on its way", hint);
            }
            if let Some(start) = self.start {
                let hint =
                    "leave `start` away: how far it walks beside the lane's centre follows from `meets`";
                wrong(
                    start.node.span(),
                    "a pedestrian who meets a vehicle along a lane says where it starts",
                    hint,
                );
            }
        }
        report.len() == before
    }
}
