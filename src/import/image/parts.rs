//! Connected parts of a picture of two classes: which pixels hang together.

/// A 4-connected part.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    /// Its class.
    pub inside: bool,
    pub pixels: usize,
    /// The first of its pixels, row by row.
    pub first: usize,
    pub touches_border: bool,
    /// Sums of x, y, x², xy, y² over its pixels' centres, relative to its first pixel, px.
    sums: [f64; 5],
}

/// A part for each label, and the label of each pixel.
pub(super) struct Parts {
    pub labels: Vec<u32>,
    pub parts: Vec<Part>,
}

/// Where a part lies and how long and wide a rectangle of the same moments is, px.
pub(super) struct Extent {
    pub centre: [f64; 2],
    /// Unit vector along the longer side.
    pub along: [f64; 2],
    pub length: f64,
    pub width: f64,
}

/// Finds the parts; `inside` gives the class of a pixel. Rows are cut into runs, and runs that touch are united: memory and time in
/// proportion to the pixels, whatever the picture shows.
pub(super) fn parts(width: usize, height: usize, inside: impl Fn(usize) -> bool) -> Parts {
    let mut labels = vec![0_u32; width * height];
    // Parent of each run in the forest of runs that hang together; a root is its own parent, and the oldest run of its tree.
    let mut parents: Vec<u32> = Vec::new();
    let mut classes: Vec<bool> = Vec::new();
    for y in 0..height {
        let mut x = 0;
        while x < width {
            let start = x;
            let class = inside(y * width + start);
            let run = parents.len() as u32;
            parents.push(run);
            classes.push(class);
            while x < width && inside(y * width + x) == class {
                labels[y * width + x] = run;
                if 0 < y {
                    let above = labels[(y - 1) * width + x];
                    if classes[above as usize] == class {
                        unite(&mut parents, above, run);
                    }
                }
                x += 1;
            }
        }
    }
    let mut parts: Vec<Part> = Vec::new();
    let mut names = vec![0_u32; parents.len()];
    for run in 0..parents.len() as u32 {
        let root = root(&mut parents, run);
        if root == run {
            names[run as usize] = parts.len() as u32;
            parts.push(Part { inside: classes[run as usize], pixels: 0, first: usize::MAX, touches_border: false, sums: [0.0; 5] });
        } else {
            names[run as usize] = names[root as usize];
        }
    }
    for (at, label) in labels.iter_mut().enumerate() {
        *label = names[*label as usize];
        let part = &mut parts[*label as usize];
        part.first = part.first.min(at);
        part.pixels += 1;
        let (x, y) = (at % width, at / width);
        part.touches_border |= x == 0 || y == 0 || x + 1 == width || y + 1 == height;
        let (dx, dy) = (x as f64 - (part.first % width) as f64, y as f64 - (part.first / width) as f64);
        for (sum, value) in part.sums.iter_mut().zip([dx, dy, dx * dx, dx * dy, dy * dy]) {
            *sum += value;
        }
    }
    Parts { labels, parts }
}

fn root(parents: &mut [u32], mut run: u32) -> u32 {
    while parents[run as usize] != run {
        let grandparent = parents[parents[run as usize] as usize];
        parents[run as usize] = grandparent;
        run = grandparent;
    }
    run
}

fn unite(parents: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
}

impl Part {
    /// Its rectangle, in a picture of this width.
    pub fn extent(&self, width: usize) -> Extent {
        let n = self.pixels as f64;
        let [x, y, xx, xy, yy] = self.sums.map(|sum| sum / n);
        // The area of a pixel has its own moment, 1/12.
        let (a, b, c) = (xx - x * x + 1.0 / 12.0, xy - x * y, yy - y * y + 1.0 / 12.0);
        let (middle, half) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
        let angle = 0.5 * (2.0 * b).atan2(a - c);
        let side = |moment: f64| (12.0 * moment.max(0.0)).sqrt();
        let centre = [(self.first % width) as f64 + 0.5 + x, (self.first / width) as f64 + 0.5 + y];
        Extent { centre, along: [angle.cos(), angle.sin()], length: side(middle + half), width: side(middle - half) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_touch_by_sides_only_and_know_their_rectangle() {
        let rows = ["..........", ".##..####.", ".#.#......", ".####...#.", ".......#.."];
        let inside = |at: usize| rows[at / 10].as_bytes()[at % 10] == b'#';
        let Parts { labels, parts } = parts(10, 5, inside);
        let mut sizes: Vec<usize> = parts.iter().filter(|p| p.inside).map(|p| p.pixels).collect();
        sizes.sort_unstable();
        assert_eq!(sizes, [1, 1, 4, 8]);
        // The gap inside the ring is open across a corner only; so it is a part of its own.
        let gap = &parts[labels[22] as usize];
        assert_eq!((gap.inside, gap.pixels, gap.touches_border), (false, 1, false));
        let bar = parts[labels[15] as usize].extent(10);
        assert!((bar.length - 4.0).abs() < 1e-12 && (bar.width - 1.0).abs() < 1e-12 && bar.centre == [7.0, 1.5]);
    }
}
