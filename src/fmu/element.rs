//! XML as elements in elements, bounded: only what a description is made of.

use std::collections::BTreeMap;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// Elements in elements, at most; descriptions need six.
const DEEPEST: usize = 64;

/// An element without its text.
#[derive(Debug, Default, PartialEq)]
pub struct Element {
    pub name: String,
    pub attributes: BTreeMap<String, String>,
    pub children: Vec<Element>,
}

impl Element {
    /// The root of a document. Entities other than those of XML itself are not known, so that none grows.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn read(text: &str) -> Result<Self, String> {
        let mut reader = Reader::from_str(text);
        let mut open = vec![Self::default()];
        let wrong = |error: &dyn std::fmt::Display| format!("is no XML: {error}");
        loop {
            match reader.read_event().map_err(|error| wrong(&error))? {
                Event::Start(start) if open.len() > DEEPEST => {
                    let name = String::from_utf8_lossy(start.name().as_ref()).into_owned();
                    return Err(format!("has more than {DEEPEST} elements in each other, down to `{name}`"));
                }
                Event::Start(start) => open.push(Self::of(&start)?),
                Event::Empty(start) => {
                    open.last_mut().expect("the document").children.push(Self::of(&start)?)
                }
                Event::End(_) => {
                    let closed = open.pop().expect("the reader checks that ends match");
                    open.last_mut().expect("the document").children.push(closed);
                }
                Event::Eof => break,
                _ => {}
            }
        }
        let document = open.pop().filter(|_| open.is_empty());
        let root = document.and_then(|document| document.children.into_iter().next());
        root.ok_or_else(|| "is no XML: it ends in an element".to_string())
    }

    fn of(start: &BytesStart) -> Result<Self, String> {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let mut attributes = BTreeMap::new();
        for attribute in start.attributes() {
            let attribute = attribute.map_err(|error| format!("is no XML: {error}"))?;
            let value = attribute
                .normalized_value(quick_xml::XmlVersion::Implicit1_0)
                .map_err(|error| format!("is no XML: {error}"))?;
            attributes.insert(text(attribute.key.as_ref()), value.into_owned());
        }
        Ok(Self { name: text(start.name().as_ref()), attributes, children: Vec::new() })
    }

    /// The first child of that name.
    pub fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }

    /// The children of the child of that name.
    pub fn inside(&self, name: &str) -> &[Self] {
        self.child(name).map_or(&[], |child| &child.children)
    }

    pub fn text(&self, attribute: &str) -> Option<&str> {
        self.attributes.get(attribute).map(String::as_str)
    }

    pub fn number(&self, attribute: &str) -> Option<f64> {
        self.text(attribute)?.trim().parse().ok()
    }

    /// As XML Schema writes truth; `false` if it is not said.
    pub fn is(&self, attribute: &str) -> bool {
        matches!(self.text(attribute).map(str::trim), Some("true" | "1"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_read_with_their_attributes() {
        let root =
            Element::read("<?xml version=\"1.0\"?><a x=\"1 &lt; 2\"><!-- no --><b y=\"true\"/>t<b/></a>")
                .unwrap();
        assert_eq!((root.name.as_str(), root.text("x"), root.children.len()), ("a", Some("1 < 2"), 2));
        assert!(root.child("b").unwrap().is("y") && !root.is("x"));
    }

    #[test]
    fn what_is_no_xml_or_grows_is_refused() {
        for text in ["", "a", "<a>", "<a></b>", "<a x=1/>", "<a x=\"&e;\"/>"] {
            assert!(Element::read(text).is_err(), "{text}");
        }
        let bomb = "<!DOCTYPE a [<!ENTITY e \"eeeeeeee\"><!ENTITY f \"&e;&e;&e;\">]><a x=\"&f;\"/>";
        assert!(Element::read(bomb).is_err());
        assert!(Element::read(&"<a>".repeat(100_000)).unwrap_err().contains("more than 64 elements"));
    }
}
