//! The grammar as data, for tests that hold views and statements against it.

use std::collections::{BTreeSet, HashMap};

use pest_meta::ast::{Expr, RuleType};
use pest_meta::parser;

/// What every rule is made of.
pub struct Grammar {
    rules: HashMap<String, (RuleType, Expr)>,
}

impl Grammar {
    pub fn read() -> Self {
        let pairs = parser::parse(parser::Rule::grammar_rules, ::grammar::scn::TEXT);
        let rules = parser::consume_rules(pairs.unwrap()).unwrap();
        Self { rules: rules.into_iter().map(|rule| (rule.name, (rule.ty, rule.expr))).collect() }
    }

    /// The rules whose nodes can be parts of a node of this rule.
    pub fn possible(&self, rule: &str) -> BTreeSet<String> {
        let mut found = BTreeSet::new();
        self.gather(&self.rules[rule].1, &mut found);
        found
    }

    fn gather(&self, expression: &Expr, found: &mut BTreeSet<String>) {
        match expression {
            Expr::Ident(name) => match self.rules.get(name) {
                Some((RuleType::Silent, inner)) => self.gather(inner, found),
                Some(_) => _ = found.insert(name.clone()),
                None => {}
            },
            Expr::Seq(one, other) | Expr::Choice(one, other) => {
                self.gather(one, found);
                self.gather(other, found);
            }
            Expr::Opt(inner) | Expr::Rep(inner) | Expr::RepOnce(inner) => self.gather(inner, found),
            _ => {}
        }
    }

    /// Whether every node of this rule has a part of one of those.
    pub fn always(&self, rule: &str, parts: &BTreeSet<String>) -> bool {
        self.has(&self.rules[rule].1, parts)
    }

    fn has(&self, expression: &Expr, parts: &BTreeSet<String>) -> bool {
        match expression {
            Expr::Ident(name) => match self.rules.get(name) {
                Some((RuleType::Silent, inner)) => self.has(inner, parts),
                _ => parts.contains(name),
            },
            Expr::Seq(one, other) => self.has(one, parts) || self.has(other, parts),
            Expr::Choice(one, other) => self.has(one, parts) && self.has(other, parts),
            Expr::RepOnce(inner) => self.has(inner, parts),
            _ => false,
        }
    }
}
