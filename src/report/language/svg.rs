//! The words of a figure: every text element of an SVG, kept within about the room that the English words had.

/// How wide a text is.
pub trait Measure {
    /// Width in em of the figures' sans.
    fn width(&self, text: &str) -> f64;
}

/// Words may grow by this much before they are set narrower: what a figure leaves between a word and its neighbour.
const ROOM: f64 = 1.1;
/// Smaller than this share of its size no word is set.
const SMALLEST: f64 = 0.75;
/// Width of the condensed letters over that of the plain ones.
const CONDENSED: f64 = 0.9;

/// The figure with every text said again by `say`.
pub fn say(figure: &str, say: &dyn Fn(&str) -> String, measure: &dyn Measure) -> String {
    let mut said = String::with_capacity(figure.len() + figure.len() / 16);
    let mut rest = figure;
    while let Some(at) = rest.find("<text") {
        let Some(open) = rest[at..].find('>').map(|i| at + i) else { break };
        let Some(close) = rest[open..].find("</text>").map(|i| open + i) else { break };
        let (tag, inside) = (&rest[at..open], &rest[open + 1..close]);
        said.push_str(&rest[..at]);
        let english = unescaped(inside.trim());
        let words = say(&english);
        if words == english || inside.contains('<') {
            said.push_str(&rest[at..close]);
        } else {
            said.push_str(&fitted(tag, measure.width(&english), measure.width(&words)));
            said.push('>');
            said.push_str(&escaped(&words));
        }
        rest = &rest[close..];
    }
    said.push_str(rest);
    said
}

/// The tag of the text with smaller letters where the words became longer.
fn fitted(tag: &str, english: f64, words: f64) -> String {
    if words <= ROOM * english {
        return tag.to_string();
    }
    // Short words get a little more: three letters instead of two disturb nobody.
    let room = ROOM * english + 1.0;
    let share = (room / (CONDENSED * words)).clamp(SMALLEST, 1.0);
    let tag = format!("{tag} font-stretch=\"condensed\"");
    let Some((before, size, after)) = attribute(&tag, "font-size=\"") else { return tag };
    match size.parse::<f64>() {
        Ok(size) => format!("{before}{}{after}", (size * share * 10.0).round() / 10.0),
        Err(_) => tag,
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
        let narrower = fitted(tag, 5.0, 7.5);
        assert!(narrower.contains("font-stretch=\"condensed\""), "{narrower}");
        assert!(fitted(tag, 5.0, 50.0).contains("font-size=\"75\""));
        assert_eq!(fitted(tag, 5.0, 5.0), tag);
    }
}
