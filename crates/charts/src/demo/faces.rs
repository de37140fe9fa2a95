//! The areas between contours: each with one outer ring and its holes, all made of shared edges.

use super::contour::Contour;

/// A part of the net that areas are made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    /// A contour or other closed line, by index.
    Line(usize),
    /// The border from one of its nodes to the next, anticlockwise, by index of the node.
    Border(usize),
}

/// A part and whether it is run backwards.
pub(super) type Run = (Part, bool);

/// An area.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Face {
    /// What is in it.
    pub(super) content: Content,
    /// Its outer ring, anticlockwise.
    pub(super) outer: Vec<Run>,
    /// Closed lines within it.
    pub(super) holes: Vec<Run>,
}

/// What is in an area.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    /// Depth from level - 1 to level; 0 is shallower than all levels.
    Band(usize),
    /// The inside of one of the lines that people made, by index among these.
    Made(usize),
}

/// A node of the border.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BorderNode {
    pub(super) at: [f64; 2],
    /// Distance along the border, anticlockwise from the south-west corner (m).
    along: f64,
    /// The contour that starts or ends here; none at a corner.
    contour: Option<(usize, bool)>,
}

impl BorderNode {
    /// Whether a contour starts here, or ends here.
    pub(super) fn ends(&self, contour: usize, starts: bool) -> bool {
        self.contour == Some((contour, starts))
    }
}

/// Lines, nodes of the border, and the areas between.
pub(super) struct Net {
    /// Contours, then the lines that people made.
    pub(super) lines: Vec<Contour>,
    /// Anticlockwise; each starts the part of the border to the next.
    pub(super) border: Vec<BorderNode>,
    pub(super) faces: Vec<Face>,
}

impl Net {
    /// Weaves the net in a rectangle from its south-west to its north-east corner. `made` are closed lines,
    /// anticlockwise, that touch no contour and each other only by lying within. `corner_band` is the band at
    /// the south-west corner.
    pub(super) fn weave(
        [south_west, north_east]: [[f64; 2]; 2],
        contours: Vec<Contour>,
        made: &[Vec<[f64; 2]>],
        corner_band: usize,
    ) -> Self {
        let border = border_nodes([south_west, north_east], &contours);
        let first_made = contours.len();
        let mut lines = contours;
        lines.extend(made.iter().map(|points| Contour { level: 0, points: points.clone(), closed: true }));
        let mut net = Self { lines, border, faces: Vec::new() };
        net.faces_at_border(corner_band);
        for line in (0..net.lines.len()).filter(|line| net.lines[*line].closed) {
            let contour = &net.lines[line];
            let shallow_inside = area(&contour.points) > 0.0;
            let content = match line.checked_sub(first_made) {
                Some(made) => Content::Made(made),
                None => Content::Band(contour.level + usize::from(!shallow_inside)),
            };
            let outer = vec![(Part::Line(line), !shallow_inside)];
            net.faces.push(Face { content, outer, holes: Vec::new() });
        }
        net.nest();
        net
    }

    /// Walks along the border with the area on the left; where a contour meets it, the walk follows that to
    /// its other end.
    fn faces_at_border(&mut self, corner_band: usize) {
        let count = self.border.len();
        let mut done = vec![false; count];
        let mut band = corner_band;
        for start in 0..count {
            // Past a contour's start it is deeper, past its end shallower.
            if let Some((contour, starts)) = self.border[start].contour {
                band = self.lines[contour].level + usize::from(starts);
            }
            if done[start] {
                continue;
            }
            let (mut outer, mut at) = (Vec::new(), start);
            while !done[at] {
                done[at] = true;
                outer.push((Part::Border(at), false));
                at = (at + 1) % count;
                if let Some((contour, starts)) = self.border[at].contour {
                    outer.push((Part::Line(contour), !starts));
                    at = self.other_end(contour, starts);
                }
            }
            self.faces.push(Face { content: Content::Band(band), outer, holes: Vec::new() });
        }
    }

    fn other_end(&self, contour: usize, starts: bool) -> usize {
        let end = self.border.iter().position(|node| node.ends(contour, !starts));
        end.expect("invariant: contours have two ends")
    }

    /// Each closed line is a hole of the smallest area that it lies in.
    fn nest(&mut self) {
        let rings: Vec<Vec<[f64; 2]>> = self.faces.iter().map(|face| self.points(&face.outer)).collect();
        let areas: Vec<f64> = rings.iter().map(|ring| area(ring)).collect();
        for inner in 0..rings.len() {
            let [(Part::Line(line), backwards)] = self.faces[inner].outer[..] else { continue };
            if !self.lines[line].closed {
                continue;
            }
            let within = |outer: &usize| *outer != inner && contains(&rings[*outer], rings[inner][0]);
            let smallest = |a: &usize, b: &usize| areas[*a].total_cmp(&areas[*b]);
            let outer = (0..rings.len()).filter(within).min_by(smallest);
            let outer = outer.expect("invariant: every closed line lies within the border");
            self.faces[outer].holes.push((Part::Line(line), !backwards));
        }
    }

    /// The points of a ring of parts; the first is not repeated.
    pub(super) fn points(&self, runs: &[Run]) -> Vec<[f64; 2]> {
        let mut points = Vec::new();
        for (part, backwards) in runs {
            match part {
                Part::Border(node) => points.push(self.border[*node].at),
                Part::Line(line) if *backwards => points.extend(self.lines[*line].points.iter().rev()),
                Part::Line(line) => points.extend(&self.lines[*line].points),
            }
        }
        points
    }
}

/// Corners and ends of contours, anticlockwise from the south-west.
fn border_nodes([[west, south], [east, north]]: [[f64; 2]; 2], contours: &[Contour]) -> Vec<BorderNode> {
    let (width, height) = (east - west, north - south);
    let along = |[x, y]: [f64; 2]| {
        // Sides are met exactly or by less than a millionth of a metre.
        if y - south < 1e-6 {
            x - west
        } else if east - x < 1e-6 {
            width + y - south
        } else if north - y < 1e-6 {
            width + height + east - x
        } else {
            2.0 * width + height + north - y
        }
    };
    let node = |at, contour| BorderNode { at, along: along(at), contour };
    let corners = [[west, south], [east, south], [east, north], [west, north]];
    let mut nodes: Vec<BorderNode> = corners.into_iter().map(|corner| node(corner, None)).collect();
    for (index, contour) in contours.iter().enumerate().filter(|(_, contour)| !contour.closed) {
        nodes.push(node(contour.points[0], Some((index, true))));
        nodes.push(node(contour.points[contour.points.len() - 1], Some((index, false))));
    }
    nodes.sort_by(|a, b| a.along.total_cmp(&b.along));
    nodes
}

/// Area of a ring, positive anticlockwise (m²).
pub(super) fn area(ring: &[[f64; 2]]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>() / 2.0
}

/// Whether a ring holds a point.
fn contains(ring: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let next = ring.iter().cycle().skip(1);
    let crosses = |(a, b): (&[f64; 2], &[f64; 2])| {
        (a[1] > y) != (b[1] > y) && x < (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) + a[0]
    };
    ring.iter().zip(next).filter(|pair| crosses(*pair)).count() % 2 == 1
}
