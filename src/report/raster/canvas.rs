//! From the tree of an SVG to pixels: plain fills and strokes, which is all that our figures are made of.

use usvg::tiny_skia_path::PathSegment;
use usvg::{FillRule, Group, LineCap, LineJoin, Node, Opacity, Paint, Path, Transform, Tree};
use vello_cpu::color::{AlphaColor, Srgb};
use vello_cpu::kurbo::{Affine, BezPath, Cap, Join, Stroke};
use vello_cpu::peniko::Fill;
use vello_cpu::{Pixmap, RasterizerSettings, RenderContext, Resources, TargetInit};

const PAPER: AlphaColor<Srgb> = AlphaColor::WHITE;

/// The drawing on white paper, `scale` pixels to its unit.
///
/// # Errors
/// What is in the drawing that is no plain fill, stroke or text.
pub fn painted(tree: &Tree, (width, height): (u16, u16), scale: f64) -> Result<Pixmap, String> {
    let mut canvas = RenderContext::new(width, height);
    group(&mut canvas, tree.root(), Affine::scale(scale))?;
    canvas.flush();
    let mut pixels = Pixmap::new(width, height);
    let settings = RasterizerSettings { target_init: TargetInit::Clear(PAPER), ..RasterizerSettings::default() };
    canvas.render_with(&mut pixels, &mut Resources::new(), settings);
    Ok(pixels)
}

fn group(canvas: &mut RenderContext, group: &Group, onto: Affine) -> Result<(), String> {
    if group.clip_path().is_some() || group.mask().is_some() || !group.filters().is_empty() {
        return Err("clip paths, masks and filters are not drawn".into());
    }
    let translucent = group.opacity() != Opacity::ONE;
    if translucent {
        canvas.push_opacity_layer(group.opacity().get());
    }
    let onto = onto * affine(group.transform());
    for node in group.children() {
        match node {
            Node::Group(inner) => self::group(canvas, inner, onto)?,
            Node::Text(text) => self::group(canvas, text.flattened(), onto)?,
            Node::Path(path) if path.is_visible() => draw(canvas, path, onto)?,
            Node::Path(_) => {}
            Node::Image(_) => return Err("pictures within pictures are not drawn".into()),
        }
    }
    if translucent {
        canvas.pop_layer();
    }
    Ok(())
}

fn draw(canvas: &mut RenderContext, path: &Path, onto: Affine) -> Result<(), String> {
    canvas.set_transform(onto);
    let outline = outline(path);
    if let Some(fill) = path.fill() {
        canvas.set_paint(color(fill.paint(), fill.opacity())?);
        canvas.set_fill_rule(match fill.rule() {
            FillRule::NonZero => Fill::NonZero,
            FillRule::EvenOdd => Fill::EvenOdd,
        });
        canvas.fill_path(&outline);
    }
    if let Some(line) = path.stroke() {
        canvas.set_paint(color(line.paint(), line.opacity())?);
        let cap = match line.linecap() {
            LineCap::Butt => Cap::Butt,
            LineCap::Round => Cap::Round,
            LineCap::Square => Cap::Square,
        };
        let join = match line.linejoin() {
            LineJoin::Miter | LineJoin::MiterClip => Join::Miter,
            LineJoin::Round => Join::Round,
            LineJoin::Bevel => Join::Bevel,
        };
        let mut stroke = Stroke::new(f64::from(line.width().get())).with_caps(cap).with_join(join);
        stroke.miter_limit = f64::from(line.miterlimit().get());
        if let Some(dashes) = line.dasharray() {
            stroke = stroke.with_dashes(f64::from(line.dashoffset()), dashes.iter().copied().map(f64::from));
        }
        canvas.set_stroke(stroke);
        canvas.stroke_path(&outline);
    }
    Ok(())
}

fn color(paint: &Paint, opacity: Opacity) -> Result<AlphaColor<Srgb>, String> {
    match paint {
        Paint::Color(color) => {
            let level = |level: u8| f32::from(level) / 255.0;
            Ok(AlphaColor::new([level(color.red), level(color.green), level(color.blue), opacity.get()]))
        }
        _ => Err("gradients and patterns are not drawn".into()),
    }
}

fn outline(path: &Path) -> BezPath {
    let mut outline = BezPath::with_capacity(path.data().len());
    for segment in path.data().segments() {
        let point = |p: usvg::tiny_skia_path::Point| (f64::from(p.x), f64::from(p.y));
        match segment {
            PathSegment::MoveTo(p) => outline.move_to(point(p)),
            PathSegment::LineTo(p) => outline.line_to(point(p)),
            PathSegment::QuadTo(a, p) => outline.quad_to(point(a), point(p)),
            PathSegment::CubicTo(a, b, p) => outline.curve_to(point(a), point(b), point(p)),
            PathSegment::Close => outline.close_path(),
        }
    }
    outline
}

fn affine(t: Transform) -> Affine {
    Affine::new([t.sx, t.ky, t.kx, t.sy, t.tx, t.ty].map(f64::from))
}
