//! A blueprint as a tree of views, with what the recorder's own builder leaves out: eye, legend, axes.

use super::rerun::blueprint::archetypes::{
    ContainerBlueprint, PanelBlueprint, TimePanelBlueprint, ViewBlueprint, ViewContents, ViewportBlueprint,
};
use super::rerun::blueprint::components::{
    AutoLayout, AutoViews, ColumnShare, ContainerKind, IncludedContent, PanelState, PlayState,
    QueryExpression, RootContainer, RowShare, TimelineName, ViewClass,
};
use super::rerun::{AsComponents, EntityPath, SerializedComponentBatch};
use super::stream::{Layout, Stream};
use crate::RecorderError;

/// A part of the window.
#[derive(Debug)]
pub(super) enum Part {
    /// Side by side, with shares of the width.
    Row(Vec<(f32, Part)>),
    /// One above the other, with shares of the height.
    Column(Vec<(f32, Part)>),
    /// One of several, chosen by tabs with these names.
    Tabs(Vec<(String, Part)>),
    /// A view.
    View(View),
}

/// A view of some entities.
#[derive(Debug)]
pub(super) struct View {
    class: &'static str,
    name: String,
    origin: EntityPath,
    contents: Vec<String>,
    properties: Vec<(&'static str, Vec<SerializedComponentBatch>)>,
}

impl View {
    /// A view of one of the recorder's classes: `3D`, `TimeSeries`, `TextLog`, `TextDocument`.
    pub(super) fn new(class: &'static str, name: impl Into<String>, origin: EntityPath) -> Self {
        Self { class, name: name.into(), origin, contents: vec!["$origin/**".into()], properties: Vec::new() }
    }

    /// Shows exactly these entities.
    pub(super) fn showing(mut self, entities: impl IntoIterator<Item = EntityPath>) -> Self {
        self.contents = entities.into_iter().map(|e| e.to_string()).collect();
        self
    }

    /// Sets a property by its archetype, whose short name is `kind`.
    pub(super) fn with(mut self, kind: &'static str, archetype: &impl AsComponents) -> Self {
        self.properties.push((kind, archetype.as_serialized_batches()));
        self
    }
}

/// Sends the layout to the viewer, or into the file, and makes it the active one.
pub(super) fn send(stream: &mut Stream, timeline: &str, root: &Part) -> Result<(), RecorderError> {
    let mut writer = Writer { layout: stream.layout(), containers: 0, views: 0 };
    let root = match writer.part(root, None)? {
        Placed::Container(id) => id,
        Placed::View(path) => writer.container(ContainerKind::Tabs, None, vec![path], &[])?,
    };
    let viewport = ViewportBlueprint::new()
        .with_root_container(RootContainer(bytes_of(root).into()))
        .with_auto_layout(AutoLayout(false.into()))
        .with_auto_views(AutoViews(false.into()));
    writer.log("viewport", &viewport)?;
    writer.log("blueprint_panel", &PanelBlueprint::new().with_state(PanelState::Collapsed))?;
    writer.log("selection_panel", &PanelBlueprint::new().with_state(PanelState::Collapsed))?;
    let time_panel = TimePanelBlueprint::new()
        .with_state(PanelState::Collapsed)
        .with_timeline(TimelineName(timeline.into()))
        .with_play_state(PlayState::Paused);
    writer.log("time_panel", &time_panel)?;

    stream.send_layout(&writer.layout)
}

/// Where a part has been put.
enum Placed {
    Container(u64),
    View(String),
}

/// A UUID from a counter: unique within one layout is all that is needed.
fn bytes_of(id: u64) -> [u8; 16] {
    (0x5ea1_e650_0000_4000_8000_0000_0000_0000_u128 + u128::from(id)).to_be_bytes()
}

fn uuid(id: u64) -> String {
    let hex: String = bytes_of(id).iter().map(|b| format!("{b:02x}")).collect();
    format!("{}-{}-{}-{}-{}", &hex[0..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..32])
}

/// A part of a container: its share of the room, or the name of its tab.
type Child<'p> = (Option<f32>, Option<&'p str>, &'p Part);

struct Writer {
    layout: Layout,
    containers: u64,
    views: u64,
}

impl Writer {
    fn log(&mut self, path: &str, what: &impl AsComponents) -> Result<(), RecorderError> {
        self.layout.log(path, what.as_serialized_batches())
    }

    /// Writes a part, which as a container takes the name that its tab gives it.
    fn part(&mut self, part: &Part, name: Option<&str>) -> Result<Placed, RecorderError> {
        let (kind, parts): (_, Vec<Child<'_>>) = match part {
            Part::View(view) => return self.view(view).map(Placed::View),
            Part::Row(parts) => {
                (ContainerKind::Horizontal, parts.iter().map(|(s, p)| (Some(*s), None, p)).collect())
            }
            Part::Column(parts) => {
                (ContainerKind::Vertical, parts.iter().map(|(s, p)| (Some(*s), None, p)).collect())
            }
            Part::Tabs(parts) => {
                (ContainerKind::Tabs, parts.iter().map(|(n, p)| (None, Some(n.as_str()), p)).collect())
            }
        };
        let mut contents = Vec::new();
        let mut shares = Vec::new();
        for (share, tab, part) in parts {
            shares.extend(share);
            contents.push(match self.part(part, tab)? {
                Placed::Container(id) => format!("container/{}", uuid(id)),
                Placed::View(path) => path,
            });
        }
        self.container(kind, name, contents, &shares).map(Placed::Container)
    }

    fn container(
        &mut self,
        kind: ContainerKind,
        name: Option<&str>,
        contents: Vec<String>,
        shares: &[f32],
    ) -> Result<u64, RecorderError> {
        self.containers += 1;
        let id = self.containers;
        let contents = contents.into_iter().map(|c| IncludedContent(c.into()));
        let mut container = ContainerBlueprint::new(kind).with_contents(contents);
        if let Some(name) = name {
            container = container.with_display_name(name);
        }
        match kind {
            ContainerKind::Horizontal => {
                container = container.with_col_shares(shares.iter().map(|&s| ColumnShare(s.into())));
            }
            ContainerKind::Vertical => {
                container = container.with_row_shares(shares.iter().map(|&s| RowShare(s.into())));
            }
            ContainerKind::Tabs | ContainerKind::Grid => {}
        }
        self.log(&format!("container/{}", uuid(id)), &container)?;
        Ok(id)
    }

    fn view(&mut self, view: &View) -> Result<String, RecorderError> {
        self.views += 1;
        // Containers and views are counted apart; a bit keeps their ids apart. The viewer keeps what it knows of a view by the
        // view's id, also when it opens another recording: views of two classes must not have the same.
        let class = view.class.bytes().fold(0, |hash: u64, byte| (31 * hash + u64::from(byte)) & 0xffff);
        let path = format!("view/{}", uuid(self.views | (1 << 32) | (class << 40)));
        let contents = ViewContents::new(view.contents.iter().map(|q| QueryExpression(q.as_str().into())));
        self.log(&format!("{path}/ViewContents"), &contents)?;
        let description = ViewBlueprint::new(ViewClass(view.class.into()))
            .with_display_name(view.name.as_str())
            .with_space_origin(view.origin.to_string());
        self.log(&path, &description)?;
        for (kind, batches) in &view.properties {
            self.layout.log(format!("{path}/{kind}"), batches.clone())?;
        }
        Ok(path)
    }
}
