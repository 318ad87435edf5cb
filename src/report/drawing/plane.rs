//! Marks in the plane, and the part of it that is shown.

use nalgebra::Vector2;

use sim::geometry::Footprint;

/// What a mark stands for, by which it gets its look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MarkKind {
    /// What vehicles drive on.
    Road,
    Kerb,
    /// Between two lanes.
    Lane,
    /// A strip between two lanes where nobody drives.
    Median,
    /// Of a zebra.
    Stripe,
    /// The outline of a crossing without stripes.
    Edge,
    /// Before which vehicles stop for a signal.
    StopLine,
    /// Something that stands there.
    Block,
}

impl MarkKind {
    /// As style sheets call it.
    pub(crate) fn class(self) -> &'static str {
        match self {
            Self::Road => "road",
            Self::Kerb => "kerb",
            Self::Lane => "lane",
            Self::Median => "median",
            Self::Stripe => "stripe",
            Self::Edge => "edge",
            Self::StopLine => "stop_line",
            Self::Block => "block",
        }
    }
}

/// A line or an area.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Mark {
    pub(crate) kind: MarkKind,
    /// Whether its last point is joined to its first.
    pub(crate) closed: bool,
    /// World frame, m.
    pub(crate) points: Vec<Vector2<f64>>,
}

impl Mark {
    pub(crate) fn line(kind: MarkKind, points: Vec<Vector2<f64>>) -> Self {
        Self { kind, closed: false, points }
    }

    pub(crate) fn area(kind: MarkKind, points: Vec<Vector2<f64>>) -> Self {
        Self { kind, closed: true, points }
    }
}

/// The corners of an outline, m; of a disc those of the square around it.
pub(crate) fn corners(outline: &Footprint) -> Vec<Vector2<f64>> {
    let (length, width) = outline.shape.extents();
    let (along, across) = (outline.heading, Vector2::new(-outline.heading.y, outline.heading.x));
    let corner =
        |(x, y): (f64, f64)| outline.centre + along * (x * length / 2.0) + across * (y * width / 2.0);
    [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)].map(corner).to_vec()
}

/// A rectangle of the plane along its axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    /// The lower left corner, m.
    pub(crate) low: Vector2<f64>,
    /// The upper right corner, m.
    pub(crate) high: Vector2<f64>,
}

impl Frame {
    /// Around points, with so much room (m) on every side.
    pub(crate) fn around(points: impl IntoIterator<Item = Vector2<f64>>, room: f64) -> Option<Self> {
        let mut points = points.into_iter().filter(|point| point.x.is_finite() && point.y.is_finite());
        let first = points.next()?;
        let (low, high) =
            points.fold((first, first), |(low, high), point| (low.inf(&point), high.sup(&point)));
        let room = Vector2::new(room, room);
        Some(Self { low: low - room, high: high + room })
    }

    pub(crate) fn size(&self) -> Vector2<f64> {
        self.high - self.low
    }

    /// Whether a point is in it.
    pub(crate) fn holds(&self, point: Vector2<f64>) -> bool {
        let (low, high) = (self.low, self.high);
        (low.x..=high.x).contains(&point.x) && (low.y..=high.y).contains(&point.y)
    }

    /// The point of it that is nearest to another.
    pub(crate) fn nearest(&self, point: Vector2<f64>) -> Vector2<f64> {
        point.sup(&self.low).inf(&self.high)
    }

    /// So large that it is at least so long and so wide (m), about the same middle.
    pub(crate) fn at_least(self, least: Vector2<f64>) -> Self {
        let missing = (least - self.size()).sup(&Vector2::zeros()) / 2.0;
        Self { low: self.low - missing, high: self.high + missing }
    }
}
