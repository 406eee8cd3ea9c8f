//! The lines over a map: true outlines, wall segments, the robot's path, the robot at its
//! end.

use amiro_ipf::geometry::{Point, Rotation};

use super::line_drawing::LineDrawing;
use super::map_picture::{MapPicture, OUTLINE, PATH};
use super::picture::Picture;
use super::pixel_grid::PixelGrid;
use super::wall_overlay::draw_walls;

/// Radius of AMiRo's round body, metres.
const AMIRO_RADIUS_M: f64 = 0.05;

/// Width of path and outlines, pixels.
const PEN_PX: f64 = 2.0;

/// Diameter of the dot at the start of the path, pixels.
const START_PX: f64 = 10.0;

/// Corners of the polygon that is drawn as a circle: off by 1e-3 of its radius.
const CIRCLE_CORNERS: u16 = 72;

/// Path, robot and outlines of a map's picture.
pub(super) struct MapOverlay<'a> {
    picture: &'a MapPicture<'a>,
    /// The last finite point of the path.
    end: Option<(f64, f64)>,
    radius_m: f64,
}

impl<'a> MapOverlay<'a> {
    pub(super) fn new(picture: &'a MapPicture<'a>) -> Self {
        let is_finite = |(x, y): &&(f64, f64)| x.is_finite() && y.is_finite();
        Self {
            picture,
            end: picture.path.iter().rfind(is_finite).copied(),
            radius_m: picture.robot_radius_m.unwrap_or(AMIRO_RADIUS_M),
        }
    }

    /// Two corners of the square around the robot at the end of its path.
    pub(super) fn robot_corners(&self) -> impl Iterator<Item = (f64, f64)> {
        let offsets = [-self.radius_m, self.radius_m].into_iter();
        let end = self.end;
        offsets.filter_map(move |offset| end.map(|(x, y)| (x + offset, y + offset)))
    }

    /// The ends of the wall segments.
    pub(super) fn wall_ends(&self) -> impl Iterator<Item = (f64, f64)> {
        let ends = self.picture.walls.iter().flat_map(|wall| wall.ends);
        ends.map(|end| (end.x, end.y))
    }

    /// Draws outlines below, wall segments and the path above them, the robot on top.
    pub(super) fn draw(&self, drawing: &mut Picture, grid: &PixelGrid) {
        let (width, height) = (drawing.width(), drawing.height());
        let mut outlines = LineDrawing::new(width, height);
        for polygon in self.picture.outlines {
            let closed = polygon.iter().chain(polygon.first());
            outlines.line(closed.map(|point| grid.place(*point)), PEN_PX);
        }
        outlines.blend(drawing, OUTLINE);
        draw_walls(self.picture.walls, drawing, grid);

        let mut lines = LineDrawing::new(width, height);
        let path = || self.picture.path.iter().map(|point| grid.place(*point));
        let starts = core::iter::once(&0).chain(self.picture.jumps);
        let ends = self.picture.jumps.iter().copied();
        for (&start, end) in starts.zip(ends.chain([self.picture.path.len()])) {
            lines.line(path().take(end).skip(start), PEN_PX);
        }
        let start = path().find(|(x, y)| x.is_finite() && y.is_finite());
        lines.line(start, START_PX);
        if let Some(end) = self.end {
            self.draw_robot(&mut lines, grid, end);
        }
        lines.blend(drawing, PATH);
    }

    /// The body's circle, and an arrow from its centre to its front.
    fn draw_robot(&self, lines: &mut LineDrawing, grid: &PixelGrid, centre: (f64, f64)) {
        let around = |radians: f32, radius_m: f64| {
            // The core's sine, which is the same on every machine.
            let direction = Point::new(1.0, 0.0).rotated(Rotation::by(radians));
            grid.place((
                centre.0 + radius_m * f64::from(direction.x),
                centre.1 + radius_m * f64::from(direction.y),
            ))
        };
        let corner = core::f32::consts::TAU / f32::from(CIRCLE_CORNERS);
        let circle = (0..=CIRCLE_CORNERS).map(|index| f32::from(index) * corner);
        lines.line(circle.map(|radians| around(radians, self.radius_m)), PEN_PX);
        let heading = self.picture.final_heading_rad;
        let Some(heading) = heading.filter(|heading| heading.is_finite()) else {
            return;
        };
        // Within a turn first: a large angle has no direction left in single precision.
        let heading = (heading % core::f64::consts::TAU) as f32;
        let tip = around(heading, 0.9 * self.radius_m);
        let barb = |side: f32| around(heading + side, 0.6 * self.radius_m);
        lines.line([around(heading, 0.0), tip], PEN_PX);
        lines.line([barb(0.5), tip, barb(-0.5)], PEN_PX);
    }
}
