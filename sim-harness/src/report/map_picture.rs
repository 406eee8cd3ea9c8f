//! A map as a picture: cells, the robot's path, the true outlines, a scale bar.

use crate::drive::WallState;
use crate::mapping::{MAX_CELLS, Map};
use crate::world::Scenario;

use super::cell_window::CellWindow;
use super::map_overlay::MapOverlay;
use super::picture::{Colour, PAPER, Picture};
use super::pixel_grid::{OCCUPIED, PixelGrid, UNKNOWN, WANTED_PX};
use super::scale_bar::draw_scale_bar;
use super::text::{Font, INK};

/// Colour of the robot and its path.
pub const PATH: Colour = [20, 110, 245];
/// Colour of the true outlines.
pub const OUTLINE: Colour = [225, 30, 30];

/// Greatest width and height of a picture of a map, pixels.
pub const MAX_SIDE_PX: usize = 4096;

/// Margin of unknown cells around the shown cells.
const MARGIN_CELLS: i32 = 5;

/// White border around everything, pixels.
const BORDER: usize = 10;

/// Narrowest room for title and scale bar, pixels.
const NARROWEST: usize = 320;

/// Lines a title may have.
const TITLE_LINES: usize = 3;

/// Distance between points on an outline, metres.
const OUTLINE_M: f64 = 0.002;

/// Additions to the cells; none by default.
#[derive(Clone, Copy, Debug, Default)]
pub struct MapPicture<'a> {
    /// A line of text above the map; broken into at most three when the map is narrow.
    pub title: Option<&'a str>,
    /// The robot's centre from start to end in the world, metres; may be empty.
    ///
    /// The picture is large enough to hold it and the robot at its end; points that are
    /// not finite are left out.
    pub path: &'a [(f64, f64)],
    /// Indices of the points of the path that are not joined to the point before, in
    /// order.
    pub jumps: &'a [usize],
    /// Radius of the robot's hull, metres; without it, AMiRo's.
    pub robot_radius_m: Option<f64>,
    /// Heading of the robot at the end of its path; without it, the circle has no arrow.
    pub final_heading_rad: Option<f64>,
    /// Closed polygons of the true shapes, metres; cut at the picture's edge.
    pub outlines: &'a [Vec<(f64, f64)>],
    /// Wall segments, drawn with a band of two standard deviations; the picture holds
    /// their ends.
    pub walls: &'a [WallState],
    /// The cells to show instead of the known ones, so that two maps can be compared.
    ///
    /// For two maps with cells of one size: [`CellWindow::known`] of both, joined.
    pub window: Option<CellWindow>,
}

impl MapPicture<'_> {
    /// Draws a map: white free, black occupied, grey unknown; x to the right, y upward.
    ///
    /// Shows the known cells, or the given window, and the path, with a margin of five cells.
    /// A cell is a square of 3 to 24 pixels, so that the longer side has about 900. A map
    /// that would exceed [`MAX_SIDE_PX`] has smaller cells, and then a pixel for a square
    /// of cells: occupied if one of them is, else free if one of them is. A map without a
    /// known cell gives a small picture with a note.
    ///
    /// Costs two passes over the map's store and one over the picture.
    #[must_use]
    pub fn render(&self, map: &Map) -> Picture {
        self.render_sized(map, WANTED_PX)
    }

    /// As [`render`](Self::render), with a longer side of about so many pixels.
    ///
    /// A cell has at least 3 pixels.
    #[must_use]
    pub(crate) fn render_sized(&self, map: &Map, side_px: usize) -> Picture {
        let Some(known) = CellWindow::known(map) else {
            return self.framed(&unknown(), None, map);
        };
        let overlay = MapOverlay::new(self);
        let window = self
            .path
            .iter()
            .copied()
            .chain(overlay.robot_corners())
            .chain(overlay.wall_ends())
            .filter_map(|(x, y)| map.cell_at(x, y))
            .fold(self.window.unwrap_or(known), CellWindow::with)
            .widened(MARGIN_CELLS);
        let grid = PixelGrid::new(&window, map.lattice(), side_px);
        let mut drawing = grid.cells(map, &window);
        overlay.draw(&mut drawing, &grid);
        self.framed(&drawing, Some(grid.pixel_m()), map)
    }

    /// The drawing on paper: title above, with a warning if the map is cut; below it a
    /// scale bar for pixels of that size.
    fn framed(&self, drawing: &Picture, pixel_m: Option<f64>, map: &Map) -> Picture {
        let font = Font::LARGE;
        let room = drawing.width().max(NARROWEST);
        let title = self
            .title
            .map(|title| font.wrapped(title, room, TITLE_LINES))
            .unwrap_or_default();
        let warning = match map.refused() {
            0 => Vec::new(),
            refused => font.wrapped(&cut_in_words(refused), room, TITLE_LINES),
        };
        let lines = || {
            let title = title.iter().map(|line| (line, INK));
            title.chain(warning.iter().map(|line| (line, OUTLINE)))
        };
        let count = lines().count();
        let head = count * font.height() + if count == 0 { 0 } else { 6 };
        let foot_y = BORDER + head + drawing.height();
        let foot = pixel_m.map_or(0, |_| BORDER + Font::SMALL.height());
        let height = foot_y + foot + BORDER;
        let mut picture = Picture::new(room + 2 * BORDER, height, PAPER);
        for (index, (line, colour)) in lines().enumerate() {
            let y = BORDER + index * font.height();
            font.draw(&mut picture, BORDER, y, line, colour);
        }
        picture.paste(BORDER, BORDER + head, drawing);
        if let Some(pixel_m) = pixel_m {
            draw_scale_bar(&mut picture, (BORDER, foot_y + BORDER), pixel_m);
        }
        picture
    }
}

/// The warning in the picture of a map that is cut.
fn cut_in_words(refused: u64) -> String {
    format!("MAP CUT at {MAX_CELLS} cells: {refused} updates of cells refused")
}

/// The text of a map without a known cell.
fn unknown() -> Picture {
    let (text, font) = ("no cell is known", Font::SMALL);
    let (width, height) = (NARROWEST, 3 * font.height());
    let mut drawing = Picture::new(width, height, UNKNOWN);
    let (x, y) = ((width - font.width(text)) / 2, font.height());
    font.draw(&mut drawing, x, y, text, OCCUPIED);
    drawing
}

/// The outlines of a scenario's shapes, a point every 2 mm.
#[must_use]
pub fn outlines(scenario: &Scenario) -> Vec<Vec<(f64, f64)>> {
    let outlines = scenario.shapes.iter().map(|shape| shape.outline(OUTLINE_M));
    outlines
        .map(|points| points.iter().map(|point| (point.x, point.y)).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Cell;
    use crate::mapping::Belief;
    use crate::report::pixel_grid::{FREE, LARGEST_CELL_PX};
    use core::f64::consts::FRAC_PI_2;

    /// A map from rows of text, the first row at the top: `#` occupied, `.` free.
    fn map(cell_m: f64, rows: &[&str]) -> Map {
        let mut map = Map::unknown(cell_m);
        for (row, line) in (0..).zip(rows.iter().rev()) {
            for (column, letter) in (0..).zip(line.chars()) {
                *map.reach(Cell { row, column }).unwrap() = Belief::of_probability(match letter {
                    '#' => 0.9,
                    '.' => 0.2,
                    _ => 0.5,
                });
            }
        }
        map
    }

    /// Pixels of a square of cells: 3 known and 5 of margin at each side.
    const SIDE: usize = 13;

    /// The middle of a cell of a 3 x 3 map, counted from the upper left one.
    fn cell(picture: &Picture, column: usize, row: usize) -> Option<Colour> {
        let middle = |index: usize| BORDER + (5 + index) * LARGEST_CELL_PX + 12;
        picture.pixel(middle(column), middle(row))
    }

    fn count(picture: &Picture, colour: Colour) -> usize {
        (0..picture.height())
            .flat_map(|y| (0..picture.width()).map(move |x| (x, y)))
            .filter(|(x, y)| picture.pixel(*x, *y) == Some(colour))
            .count()
    }

    #[test]
    fn three_by_three_cells_have_their_colours_and_y_goes_up() {
        let picture = MapPicture::default().render(&map(0.01, &["#. ", ".# ", " .#"]));
        let expected = [
            [OCCUPIED, FREE, UNKNOWN],
            [FREE, OCCUPIED, UNKNOWN],
            [UNKNOWN, FREE, OCCUPIED],
        ];
        for (row, colours) in expected.iter().enumerate() {
            for (column, colour) in colours.iter().enumerate() {
                let drawn = cell(&picture, column, row);
                assert_eq!(drawn, Some(*colour), "column {column}, row {row}");
            }
        }
        let map_px = SIDE * LARGEST_CELL_PX;
        let area = LARGEST_CELL_PX * LARGEST_CELL_PX;
        let unknown = count(&picture, UNKNOWN);
        assert_eq!(unknown, map_px * map_px - 6 * area);
        assert_eq!(picture.pixel(BORDER - 1, BORDER), Some(PAPER));
        assert_eq!(picture.pixel(BORDER, BORDER), Some(UNKNOWN));
        let last = BORDER + map_px - 1;
        assert_eq!(picture.pixel(last, last), Some(UNKNOWN));
        assert_eq!(picture.pixel(last, last + 1), Some(PAPER));
    }

    #[test]
    fn a_metre_of_cells_is_about_900_pixels_wide() {
        for (cell_m, cells, cell_px) in [(0.01, 90, 9), (0.005, 190, 4), (0.002, 490, 3)] {
            let row = ".".repeat(cells);
            let rows = vec![row.as_str(); cells];
            let picture = MapPicture::default().render(&map(cell_m, &rows));
            assert_eq!(picture.width(), (cells + 10) * cell_px + 2 * BORDER);
            assert_eq!(
                count(&picture, UNKNOWN),
                20 * (cells + 5) * cell_px * cell_px
            );
        }
    }

    #[test]
    fn path_pixels_lie_where_the_robot_was() {
        let grid = map(0.01, &[".........."; 10]);
        let picture = MapPicture {
            path: &[(0.005, 0.015), (0.005, 0.095)],
            ..MapPicture::default()
        }
        .render(&grid);
        // The robot's circle takes the picture to column -5 and row 14.
        let at = |x: f64, y: f64| {
            let px = |metres: f64| (metres * 100.0 * LARGEST_CELL_PX as f64).round() as usize;
            picture.pixel(BORDER + px(x + 0.1), BORDER + px(0.2 - y))
        };
        assert_eq!(at(0.005, 0.05), Some(PATH));
        assert_eq!(at(0.005, 0.095), Some(PATH));
        assert_eq!(at(0.006_2, 0.015), Some(PATH), "the start's dot");
        assert_eq!(at(0.006_2, 0.03), Some(FREE));
        // The polygon's edge lies a hair inside the circle: almost the full colour.
        let circle = at(0.055, 0.095).unwrap_or(FREE);
        assert!(circle[0] < PATH[0] + 20, "the robot's circle: {circle:?}");
        assert_eq!(at(0.045, 0.095), Some(FREE));
        assert_eq!(at(0.025, 0.095), Some(FREE), "no arrow without a heading");
    }

    #[test]
    fn the_arrow_points_where_the_robot_looks() {
        let grid = map(0.01, &["..........."; 11]);
        let centre = (0.055, 0.055);
        for (heading, ahead) in [(0.0, (0.08, 0.055)), (FRAC_PI_2, (0.055, 0.08))] {
            let picture = MapPicture {
                path: &[centre],
                final_heading_rad: Some(heading),
                ..MapPicture::default()
            }
            .render(&grid);
            let px = |metres: f64| (metres * 2400.0).round() as usize;
            let at =
                |(x, y): (f64, f64)| picture.pixel(BORDER + px(x + 0.05), BORDER + px(0.16 - y));
            assert_eq!(at(ahead), Some(PATH), "heading {heading}");
            let behind = (2.0 * centre.0 - ahead.0, 2.0 * centre.1 - ahead.1);
            assert_eq!(at(behind), Some(FREE), "heading {heading}");
        }
    }

    #[test]
    fn outlines_are_closed_and_cut_at_the_edge() {
        let grid = map(0.01, &[".........."; 10]);
        let outlines = [vec![(0.02, 0.02), (5.0, 0.02), (0.02, 5.0)]];
        let picture = MapPicture {
            outlines: &outlines,
            ..MapPicture::default()
        }
        .render(&grid);
        let px = |metres: f64| (metres * 2400.0).round() as usize;
        let at = |x: f64, y: f64| picture.pixel(BORDER + px(x + 0.05), BORDER + px(0.15 - y));
        assert_eq!(at(0.06, 0.02), Some(OUTLINE));
        assert_eq!(
            at(0.02, 0.06),
            Some(OUTLINE),
            "from the last corner to the first"
        );
        assert_eq!(picture.width(), 20 * LARGEST_CELL_PX + 2 * BORDER);
    }

    #[test]
    fn the_same_map_gives_the_same_bytes_everywhere() {
        let grid = map(0.01, &["####", "#..#", "# ..", "####"]);
        let path: Vec<_> = (0..40)
            .map(|step| {
                (
                    0.001 * f64::from(step),
                    0.02 + 1e-5 * f64::from(step * step),
                )
            })
            .collect();
        let outlines = [vec![(0.01, 0.01), (0.03, 0.012), (0.02, 0.04)]];
        let render = || {
            let picture = MapPicture {
                robot_radius_m: None,
                title: Some("twice"),
                path: &path,
                jumps: &[],
                final_heading_rad: Some(0.4),
                outlines: &outlines,
                walls: &[],
                window: None,
            };
            picture.render(&grid)
        };
        let bytes = |picture: Picture| {
            let mut bytes = Vec::new();
            picture.write_png(&mut bytes).unwrap();
            bytes
        };
        let first = bytes(render());
        assert_eq!(first, bytes(render()));
        // Pinned, so that another machine, compiler or font is noticed: look at the
        // picture before changing the number.
        assert_eq!(render().checksum(), 2_453_021_538);
        let says = |chunk: &[u8]| first.windows(4).any(|window| window == chunk);
        assert!(!says(b"tIME") && !says(b"tEXt"));
    }

    #[test]
    fn a_map_without_a_known_cell_has_a_note() {
        let mut grid = Map::unknown(0.01);
        let picture = MapPicture::default().render(&grid);
        assert!(picture.width() <= 400 && picture.height() <= 200);
        let grey = 320 * 48;
        assert!(
            (grey / 2..grey - 300).contains(&count(&picture, UNKNOWN)),
            "no font"
        );
        *grid.reach(Cell { row: 3, column: 3 }).unwrap() = Belief::of_probability(0.5);
        let titled = MapPicture {
            title: Some("nothing"),
            path: &[(0.0, 0.0), (1.0, 1.0)],
            ..MapPicture::default()
        };
        assert!(titled.render(&grid).height() > picture.height());
    }

    #[test]
    fn a_map_that_is_cut_has_a_red_note() {
        let mut grid = map(0.01, &["#"]);
        let whole = MapPicture::default().render(&grid);
        assert_eq!(count(&whole, OUTLINE), 0);
        assert!(grid.reach_at(9e5, 9e5).is_none());
        let cut = MapPicture::default().render(&grid);
        assert!(count(&cut, OUTLINE) > 100, "{}", count(&cut, OUTLINE));
        assert!(cut.height() > whole.height());
    }

    #[test]
    fn no_line_leads_across_a_jump_of_the_path() {
        let grid = map(0.01, &[".........."; 10]);
        let path = [(0.005, 0.05), (0.02, 0.05), (0.08, 0.05), (0.095, 0.05)];
        let between = |jumps| {
            let picture = MapPicture {
                path: &path,
                jumps,
                ..MapPicture::default()
            }
            .render(&grid);
            // The picture begins five cells before the map's first.
            let column = |x: f64| BORDER + ((x + 0.05) * 2400.0).round() as usize;
            let rows = 0..picture.height();
            let blue = rows
                .flat_map(|y| (column(0.03)..column(0.04)).map(move |x| (x, y)))
                .filter(|(x, y)| picture.pixel(*x, *y) == Some(PATH));
            blue.count()
        };
        assert!(between(&[]) > 20, "{}", between(&[]));
        assert_eq!(between(&[2]), 0);
    }

    #[test]
    fn one_cell_is_a_map() {
        let picture = MapPicture::default().render(&map(0.01, &["#"]));
        let middle = BORDER + 5 * LARGEST_CELL_PX;
        assert_eq!(picture.pixel(middle, middle), Some(OCCUPIED));
        assert_eq!(picture.pixel(middle - 1, middle), Some(UNKNOWN));
        let far = middle + LARGEST_CELL_PX - 1;
        assert_eq!(picture.pixel(far, far), Some(OCCUPIED));
        assert_eq!(picture.pixel(far + 1, far), Some(UNKNOWN));
    }

    #[test]
    fn huge_maps_stay_below_the_cap_and_lose_no_wall() {
        let mut grid = Map::unknown(0.01);
        for (row, column, p_occ) in [
            (0, 0, 0.9),
            (0, 59_900, 0.9),
            (3, 30_000, 0.9),
            (4, 30_001, 0.1),
        ] {
            *grid.reach(Cell { row, column }).unwrap() = Belief::of_probability(p_occ);
        }
        let title = "word ".repeat(2000);
        let picture = MapPicture {
            title: Some(&title),
            ..MapPicture::default()
        }
        .render(&grid);
        assert!(picture.width() <= MAX_SIDE_PX && picture.height() <= MAX_SIDE_PX);
        assert!(picture.width() > MAX_SIDE_PX / 2);
        assert_eq!(count(&picture, OCCUPIED), 3);

        // A path to nowhere costs no more than a long one.
        let lost = MapPicture {
            path: &[(0.0, 0.0), (0.0, 9.9e6), (f64::NAN, 0.0), (-9.9e6, 1e300)],
            ..MapPicture::default()
        }
        .render(&map(0.01, &["#"]));
        assert!(lost.width() <= MAX_SIDE_PX && lost.height() <= MAX_SIDE_PX);
    }

    #[test]
    fn maps_in_one_window_align() {
        let (one, other) = (
            map(0.01, &["#.", ".."]),
            map(0.01, &["#...#", ".....", "....."]),
        );
        let window = CellWindow::known(&one).zip(CellWindow::known(&other));
        let window = window.map(|(one, other)| one.joined(other));
        let size = |map: &Map| {
            let picture = MapPicture {
                window,
                ..MapPicture::default()
            };
            let picture = picture.render(map);
            (picture.width(), picture.height())
        };
        assert_eq!(size(&one), size(&other));
    }

    #[test]
    fn the_scale_bar_has_the_length_of_its_label() {
        // 90 known cells of 10 mm and a margin: 9 pixels a cell, 100 mm are 90 pixels.
        let row = ".".repeat(90);
        let picture = MapPicture::default().render(&map(0.01, &[row.as_str(); 90]));
        let middle = BORDER + 900 + BORDER + Font::SMALL.height() / 2;
        let inked = (0..130).filter(|x| picture.pixel(*x, middle) == Some(INK));
        assert_eq!(inked.take_while(|x| *x < BORDER + 95).count(), 90);
    }
}
