//! The order of links and joints: one root, no cycle, parents before children.

use super::RobotFault;

/// A joint as far as the order goes.
#[derive(Debug, Clone)]
pub(super) struct Edge {
    /// The joint's name.
    pub name: String,
    /// Index of the parent link.
    pub parent: usize,
    /// Index of the child link.
    pub child: usize,
}

/// The root and, in topological order, the joints that carry the other links: depth first, in the order of
/// the file. A fault comes with the element that it belongs to.
pub(super) fn order(links: &[&str], edges: &[Edge]) -> Result<(usize, Vec<usize>), (String, RobotFault)> {
    if links.is_empty() {
        return Err(("robot".to_owned(), RobotFault::NoLink));
    }
    let mut carrier: Vec<Option<usize>> = vec![None; links.len()];
    for (i, edge) in edges.iter().enumerate() {
        if let Some(first) = carrier[edge.child].replace(i) {
            let fault = RobotFault::TwoParents {
                link: links[edge.child].to_owned(),
                first: edges[first].name.clone(),
                second: edge.name.clone(),
            };
            return Err((format!("joint '{}'", edge.name), fault));
        }
    }
    let roots: Vec<usize> = (0..links.len()).filter(|l| carrier[*l].is_none()).collect();
    // Every link has at most one parent: one that is not reached from a root hangs on a cycle.
    let mut reached = vec![false; links.len()];
    let mut joints = Vec::with_capacity(edges.len());
    let mut open: Vec<usize> = roots.iter().rev().copied().collect();
    while let Some(link) = open.pop() {
        reached[link] = true;
        if let Some(joint) = carrier[link] {
            joints.push(joint);
        }
        open.extend(edges.iter().rev().filter(|e| e.parent == link).map(|e| e.child));
    }
    if let Some(start) = reached.iter().position(|r| !r) {
        let cycle = cycle(links, edges, &carrier, start);
        return Err((format!("link '{}'", cycle[0]), RobotFault::Cycle(cycle)));
    }
    match roots.as_slice() {
        [root] => Ok((*root, joints)),
        _ => {
            let names = roots.iter().map(|r| links[*r].to_owned()).collect();
            Err((format!("link '{}'", links[roots[1]]), RobotFault::Roots(names)))
        }
    }
}

/// The links of the cycle above `start`, from parent to child, the first again at the end.
fn cycle(links: &[&str], edges: &[Edge], carrier: &[Option<usize>], start: usize) -> Vec<String> {
    let up = |link: usize| carrier[link].map_or(link, |j| edges[j].parent);
    let first = (0..links.len()).fold(start, |link, _| up(link));
    let mut ring = vec![links[first].to_owned()];
    let mut at = up(first);
    while at != first {
        ring.push(links[at].to_owned());
        at = up(at);
    }
    ring.push(links[first].to_owned());
    ring.reverse();
    ring
}
