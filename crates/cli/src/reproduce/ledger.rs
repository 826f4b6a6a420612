//! What is computed for the published rows: one entry per row, with a line of why.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::published::{Published, Verdict};

/// A row of the reproduction: print, ours, and what to think of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Row id.
    pub id: String,
    /// Place in the dissertation.
    pub reference: String,
    /// What it is.
    pub quantity: String,
    /// Unit of `published` and `ours`.
    pub unit: String,
    /// As printed; empty where nothing is.
    pub published: String,
    /// Recomputed; absent for a statement.
    pub ours: Option<f64>,
    /// Ours over the print, less one.
    pub deviation: Option<f64>,
    /// The verdict.
    pub verdict: Verdict,
    /// A line of why.
    pub why: String,
}

/// Collects values of ours by row.
#[derive(Debug)]
pub struct Ledger<'a> {
    published: &'a [Published],
    ours: BTreeMap<String, (f64, String)>,
    unjudged: BTreeSet<String>,
    remarks: BTreeMap<String, String>,
}

impl<'a> Ledger<'a> {
    /// An empty ledger for these rows.
    #[must_use]
    pub fn new(published: &'a [Published]) -> Self {
        Self { published, ours: BTreeMap::new(), unjudged: BTreeSet::new(), remarks: BTreeMap::new() }
    }

    /// Enters a value in the row's unit with its line of why.
    pub fn put(&mut self, id: &str, ours: f64, why: impl Into<String>) {
        debug_assert!(self.published.iter().any(|p| p.id == id), "no published row {id}");
        self.ours.insert(id.to_owned(), (ours, why.into()));
    }

    /// Enters a value that the print cannot be recomputed from: shown beside the statement, not judged.
    pub fn note_value(&mut self, id: &str, ours: f64, why: impl Into<String>) {
        self.put(id, ours, why);
        self.unjudged.insert(id.to_owned());
    }

    /// Enters a remark on a statement.
    pub fn remark(&mut self, id: &str, why: impl Into<String>) {
        self.remarks.insert(id.to_owned(), why.into());
    }

    /// A printed value that others are computed from.
    ///
    /// # Errors
    ///
    /// If there is no such row or it is no number.
    pub fn printed(&self, id: &str) -> anyhow::Result<f64> {
        self.published
            .iter()
            .find(|p| p.id == id)
            .and_then(|p| p.value)
            .ok_or_else(|| anyhow::anyhow!("published-values.csv has no number in row {id}"))
    }

    /// The rows in the order of the text; those without an entry are statements.
    #[must_use]
    pub fn rows(&self) -> Vec<Row> {
        self.published
            .iter()
            .map(|p| {
                let entry = self.ours.get(&p.id);
                let judged = entry.filter(|_| !self.unjudged.contains(&p.id));
                Row {
                    id: p.id.clone(),
                    reference: p.reference.clone(),
                    quantity: p.quantity.clone(),
                    unit: p.unit.clone(),
                    published: p.printed.clone(),
                    ours: entry.map(|e| e.0),
                    deviation: entry.and_then(|e| p.deviation(e.0)),
                    verdict: judged.map_or(Verdict::Statement, |e| p.judge(e.0)),
                    why: entry.map(|e| &e.1).or(self.remarks.get(&p.id)).cloned().unwrap_or_default(),
                }
            })
            .collect()
    }
}
