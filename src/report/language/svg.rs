//! The words of a figure: every text element of an SVG, kept within the room that it has.

use super::room::{Extent, Place, sheet, signs};

/// How wide a text is.
pub trait Measure {
    /// Width in em of the figures' sans.
    fn width(&self, text: &str) -> f64;
}

/// Smaller than this share of its size no word is set.
const SMALLEST: f64 = 0.75;
/// Width of the condensed letters over that of the plain ones.
const CONDENSED: f64 = 0.9;
/// Width of bold letters over that of the plain ones.
const BOLD: f64 = 1.15;

/// A text element: where it stands in the figure's source and on the sheet, what it says in English and, where that differs, in the other language.
struct Text<'f> {
    from: usize,
    tag: &'f str,
    to: usize,
    english: String,
    words: Option<String>,
    place: Option<Place>,
}

/// The figure with every text said again by `say`. A word that became longer may take what is free on its line; where that is not enough, it is set condensed,
/// then smaller.
pub fn say(figure: &str, say: &dyn Fn(&str) -> String, measure: &dyn Measure) -> String {
    let texts = texts(figure, say);
    let sheet = sheet(figure);
    let signs = if texts.iter().any(|text| text.words.is_some()) { signs(figure) } else { vec![] };
    let wide = |place: &Place, words: &str| measure.width(words) * place.size * if place.bold { BOLD } else { 1.0 };
    // Where every word stands: in English until it is said.
    let extent = |text: &Text<'_>| text.place.as_ref().map(|place| place.extent(wide(place, &text.english)));
    let mut stand: Vec<Option<Extent>> = texts.iter().map(extent).collect();
    let mut whole = String::with_capacity(figure.len() + figure.len() / 16);
    let mut done = 0;
    for (i, text) in texts.iter().enumerate() {
        let Some(words) = &text.words else { continue };
        whole.push_str(&figure[done..text.from]);
        match (&text.place, sheet) {
            (Some(place), Some(sheet)) if wide(place, &text.english) < wide(place, words) => {
                let others: Vec<Extent> = stand.iter().enumerate().filter(|(j, _)| *j != i).filter_map(|(_, extent)| *extent).collect();
                let width = wide(place, words);
                let room = place.room(wide(place, &text.english), sheet, &others, &signs);
                let (tag, share) = fitted(text.tag, width, room);
                stand[i] = Some(place.extent(share * width));
                whole.push_str(&tag);
            }
            _ => whole.push_str(text.tag),
        }
        whole.push('>');
        whole.push_str(&escaped(words));
        done = text.to;
    }
    whole.push_str(&figure[done..]);
    whole
}

/// Every text element, in order.
fn texts<'f>(figure: &'f str, say: &dyn Fn(&str) -> String) -> Vec<Text<'f>> {
    let mut texts = vec![];
    let mut from = 0;
    while let Some(at) = figure[from..].find("<text").map(|i| from + i) {
        let Some(open) = figure[at..].find('>').map(|i| at + i) else { break };
        let Some(to) = figure[open..].find("</text>").map(|i| open + i) else { break };
        let (tag, inside) = (&figure[at..open], &figure[open + 1..to]);
        let english = unescaped(inside.trim());
        let words = Some(say(&english)).filter(|words| *words != english && !inside.contains('<'));
        texts.push(Text { from: at, tag, to, english, words, place: Place::of(tag) });
        from = to;
    }
    texts
}

/// The tag of a text for words of some width in some room, and by how much narrower they become.
fn fitted(tag: &str, width: f64, room: f64) -> (String, f64) {
    if width <= room {
        return (tag.to_string(), 1.0);
    }
    let share = (room / (CONDENSED * width)).clamp(SMALLEST, 1.0);
    let tag = format!("{tag} font-stretch=\"condensed\"");
    let Some((before, size, after)) = attribute(&tag, "font-size=\"") else { return (tag, CONDENSED) };
    match size.parse::<f64>() {
        // Rounded down: a tenth of a step too wide is a collision.
        Ok(size) => (format!("{before}{}{after}", (size * share * 10.0).floor() / 10.0), CONDENSED * share),
        Err(_) => (tag, CONDENSED),
    }
}

/// What stands before, in and after the value of an attribute.
fn attribute<'t>(tag: &'t str, name: &str) -> Option<(&'t str, &'t str, &'t str)> {
    let from = tag.find(name)? + name.len();
    let to = from + tag[from..].find('"')?;
    Some((&tag[..from], &tag[from..to], &tag[to..]))
}

fn unescaped(text: &str) -> String {
    text.replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&quot;", "\"")
        .replace("&apos;", "'")
        .replace("&#39;", "'")
        .replace("&amp;", "&")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every letter is half an em wide.
    struct Even;

    impl Measure for Even {
        fn width(&self, text: &str) -> f64 {
            0.5 * text.chars().count() as f64
        }
    }

    #[test]
    fn words_are_said_again_and_drawings_stay() {
        let figure = "<svg><line x=\"1\"/><text x=\"2\" font-size=\"10\" font-family=\"DejaVu Sans\">\nfitted &lt; 3\n</text><path/></svg>";
        let to = |text: &str| if text == "fitted < 3" { "подбор < 3".to_string() } else { text.to_string() };
        let said = say(figure, &to, &Even);
        assert_eq!(
            said,
            "<svg><line x=\"1\"/><text x=\"2\" font-size=\"10\" font-family=\"DejaVu Sans\">подбор &lt; 3</text><path/></svg>"
        );
    }

    #[test]
    fn longer_words_are_set_narrower_but_never_too_small_to_read() {
        let tag = "<text font-size=\"100\" font-family=\"DejaVu Sans\"";
        let narrower = fitted(tag, 100.0, 95.0);
        assert!(narrower.0.contains("font-stretch=\"condensed\"") && narrower.0.contains("font-size=\"100\""), "{narrower:?}");
        assert!(fitted(tag, 500.0, 100.0).0.contains("font-size=\"75\""));
        assert_eq!(fitted(tag, 100.0, 100.0), (tag.to_string(), 1.0));
    }

    #[test]
    fn a_word_with_free_paper_beside_it_keeps_its_size() {
        let two = |second: usize| {
            format!(
                "<svg viewBox=\"0 0 1000 100\"><text x=\"10\" y=\"50\" font-size=\"40\">one</text>\
                 <text x=\"{second}\" y=\"50\" font-size=\"40\">other</text></svg>"
            )
        };
        let to = |text: &str| if text == "one" { "единственный".to_string() } else { text.to_string() };
        assert!(!say(&two(500), &to, &Even).contains("condensed"));
        assert!(say(&two(250), &to, &Even).contains("condensed"));
    }
}
