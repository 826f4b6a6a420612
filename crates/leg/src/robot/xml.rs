//! A first look at a URDF as XML: what is missing, is no number or is not supported is found here, with its line.

use std::collections::{BTreeMap, HashMap};

use roxmltree::{Document, Node};

use super::RobotFault;
use crate::LegError;

/// What the first look found.
#[derive(Debug, Default)]
pub(super) struct Survey {
    /// Line of each element by its name in messages, `link 'shank'`.
    lines: BTreeMap<String, u32>,
    /// What is there and is not supported.
    pub warnings: Vec<String>,
}

impl Survey {
    /// The line on which an element starts, where it has a name.
    pub fn line(&self, element: &str) -> Option<u32> {
        self.lines.get(element).copied()
    }
}

/// Child elements that are understood.
fn known_children(tag: &str) -> &'static [&'static str] {
    match tag {
        "robot" => &["link", "joint", "material"],
        "link" => &["inertial", "visual", "collision"],
        "inertial" => &["origin", "mass", "inertia"],
        "visual" => &["origin", "geometry", "material"],
        "collision" => &["origin", "geometry"],
        "geometry" => &["box", "cylinder", "capsule", "sphere", "mesh"],
        "material" => &["color"],
        "joint" => &["origin", "parent", "child", "axis", "limit", "dynamics", "mimic"],
        _ => &[],
    }
}

/// Child elements without which an element means nothing.
fn required_children(tag: &str) -> &'static [&'static str] {
    match tag {
        "inertial" => &["mass", "inertia"],
        "visual" | "collision" => &["geometry"],
        "joint" => &["parent", "child"],
        _ => &[],
    }
}

/// Attributes of numbers: name, how many, whether required.
fn numbers(tag: &str) -> &'static [(&'static str, usize, bool)] {
    match tag {
        "origin" => &[("xyz", 3, false), ("rpy", 3, false)],
        "mass" => &[("value", 1, true)],
        "inertia" => &[
            ("ixx", 1, true),
            ("ixy", 1, true),
            ("ixz", 1, true),
            ("iyy", 1, true),
            ("iyz", 1, true),
            ("izz", 1, true),
        ],
        "box" => &[("size", 3, true)],
        "cylinder" | "capsule" => &[("radius", 1, true), ("length", 1, true)],
        "sphere" => &[("radius", 1, true)],
        "mesh" => &[("scale", 3, false)],
        "color" => &[("rgba", 4, true)],
        "axis" => &[("xyz", 3, true)],
        "limit" => &[("lower", 1, false), ("upper", 1, false), ("effort", 1, false), ("velocity", 1, false)],
        "dynamics" => &[("damping", 1, false), ("friction", 1, false)],
        _ => &[],
    }
}

/// Attributes of text that are required.
fn texts(tag: &str) -> &'static [&'static str] {
    match tag {
        "link" => &["name"],
        "joint" => &["name", "type"],
        "parent" | "child" => &["link"],
        "mimic" => &["joint"],
        "mesh" => &["filename"],
        _ => &[],
    }
}

/// Elements inside each other beyond which a file is refused: URDF itself needs five, the plugins of simulators
/// some ten more.
const MOST_NESTED: u32 = 256;

/// Reads the text as XML.
pub(super) fn parse<'a>(text: &'a str, file: &str) -> Result<Document<'a>, LegError> {
    let fault = |line, fault| LegError::Robot {
        file: file.to_owned(),
        line: Some(line),
        element: "URDF".to_owned(),
        fault: Box::new(fault),
    };
    let document =
        Document::parse(text).map_err(|e| fault(e.pos().row, RobotFault::NotXml(e.to_string())))?;
    // Document order: a parent comes before what is in it.
    let mut depths: HashMap<roxmltree::NodeId, u32> = HashMap::new();
    for node in document.root_element().descendants().filter(Node::is_element) {
        let depth = node.parent().and_then(|p| depths.get(&p.id())).map_or(1, |d| d + 1);
        if depth > MOST_NESTED {
            return Err(fault(
                document.text_pos_at(node.range().start).row,
                RobotFault::NestedTooDeep(MOST_NESTED),
            ));
        }
        depths.insert(node.id(), depth);
    }
    Ok(document)
}

/// Looks over the whole document.
pub(super) fn survey(document: &Document, file: &str) -> Result<Survey, LegError> {
    let root = document.root_element();
    let mut look = Look { file, document, found: Survey::default(), unread: BTreeMap::new() };
    if root.tag_name().name() != "robot" {
        let tag = root.tag_name().name();
        let problem = format!("the outermost element is <{tag}>, not <robot>");
        return Err(look.error(root, "URDF".to_owned(), RobotFault::NotUrdf(problem)));
    }
    look.element(root, "robot")?;
    for ((tag, parent), (line, count)) in std::mem::take(&mut look.unread) {
        let more = if count > 1 { format!(" (and {} more)", count - 1) } else { String::new() };
        look.found
            .warnings
            .push(format!("{file}:{line}: <{tag}> in {parent} is not supported and was not read{more}"));
    }
    Ok(look.found)
}

struct Look<'a, 'input> {
    file: &'a str,
    document: &'a Document<'input>,
    found: Survey,
    /// Elements that are not read, by tag and where: first line and count.
    unread: BTreeMap<(String, String), (u32, usize)>,
}

impl Look<'_, '_> {
    fn line(&self, node: Node) -> u32 {
        self.document.text_pos_at(node.range().start).row
    }

    fn error(&self, node: Node, element: String, fault: RobotFault) -> LegError {
        LegError::Robot {
            file: self.file.to_owned(),
            line: Some(self.line(node)),
            element,
            fault: Box::new(fault),
        }
    }

    /// Checks an element, whose place in messages is `place`, and what is in it.
    fn element(&mut self, node: Node, place: &str) -> Result<(), LegError> {
        let tag = node.tag_name().name();
        for attribute in texts(tag) {
            if node.attribute(*attribute).is_none_or(|v| v.trim().is_empty()) {
                let missing = RobotFault::Missing(format!("attribute '{attribute}'"));
                return Err(self.error(node, place.to_owned(), missing));
            }
        }
        self.numbers(node, place)?;
        for required in required_children(tag) {
            if !node.children().any(|c| c.has_tag_name(*required)) {
                return Err(self.error(node, place.to_owned(), RobotFault::Missing(format!("<{required}>"))));
            }
        }
        for child in node.children().filter(Node::is_element) {
            let name = child.tag_name().name();
            if !known_children(tag).contains(&name) {
                // What is not supported inside a joint or link is named one by one: it changes that joint.
                let parent = if name == "safety_controller" || tag == "link" {
                    place.to_owned()
                } else {
                    format!("<{tag}>")
                };
                let line = self.line(child);
                self.unread.entry((name.to_owned(), parent)).or_insert((line, 0)).1 += 1;
                continue;
            }
            let inside = self.place(child, place)?;
            self.element(child, &inside)?;
        }
        Ok(())
    }

    /// The name of an element in messages; takes note of links and joints.
    fn place(&mut self, child: Node, parent: &str) -> Result<String, LegError> {
        let tag = child.tag_name().name();
        if matches!(tag, "link" | "joint") {
            let name = child.attribute("name").unwrap_or_default();
            let place = format!("{tag} '{name}'");
            if !name.is_empty() && self.found.lines.insert(place.clone(), self.line(child)).is_some() {
                return Err(self.error(child, place, RobotFault::Duplicate(name.to_owned())));
            }
            return Ok(place);
        }
        let place = if parent == "robot" { tag.to_owned() } else { format!("{parent} {tag}") };
        let line = self.line(child);
        self.found.lines.entry(place.clone()).or_insert(line);
        Ok(place)
    }

    fn numbers(&self, node: Node, place: &str) -> Result<(), LegError> {
        for (attribute, count, required) in numbers(node.tag_name().name()) {
            let Some(value) = node.attribute(*attribute) else {
                if *required {
                    let missing = RobotFault::Missing(format!("attribute '{attribute}'"));
                    return Err(self.error(node, place.to_owned(), missing));
                }
                continue;
            };
            let element = || format!("{place} {attribute}");
            let words: Vec<&str> = value.split_whitespace().collect();
            let not_numbers =
                || RobotFault::NotUrdf(format!("'{value}' is not {count} number{}", plural(*count)));
            if words.len() != *count {
                return Err(self.error(node, element(), not_numbers()));
            }
            for word in words {
                let number: f64 = word.parse().map_err(|_| self.error(node, element(), not_numbers()))?;
                // An infinite limit is none.
                let limit = node.tag_name().name() == "limit" && number.is_infinite();
                if !number.is_finite() && !limit {
                    let fault = RobotFault::BadValue { value: number, admitted: "finite" };
                    return Err(self.error(node, element(), fault));
                }
            }
        }
        Ok(())
    }
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}
