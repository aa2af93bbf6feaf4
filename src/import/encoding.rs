//! Encoding: bytes of a text file → text, and the name of the encoding that was found or told.

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1251, WINDOWS_1252};

/// A decoded text.
#[derive(Debug)]
pub(super) struct Decoded {
    pub text: String,
    /// As a person calls it: `UTF-8 with BOM`, `UTF-16LE`, `windows-1251` ….
    pub name: String,
}

/// The encoding of a label such as `windows-1251`, `utf-16le`, `koi8-r` (WHATWG Encoding Standard).
pub(super) fn known(label: &str) -> Option<&'static Encoding> {
    Encoding::for_label(label.trim().as_bytes())
}

/// Decodes a text. A byte order mark decides; then what was `told`; then UTF-16 by its zero bytes, UTF-8 if it is valid, and Windows-1251 or
/// -1252 by how letters beyond ASCII stand together.
///
/// # Errors
/// The problem, as a sentence, if this is no text: zero bytes, or bytes that the told encoding does not have.
pub(super) fn decode(bytes: &[u8], told: Option<&str>) -> Result<Decoded, String> {
    if let Some((encoding, length)) = Encoding::for_bom(bytes) {
        return whole(encoding, &bytes[length..], format!("{} with BOM", encoding.name()));
    }
    if let Some(label) = told {
        let encoding = known(label).ok_or_else(|| format!("“{label}” is no encoding known here"))?;
        return whole(encoding, bytes, encoding.name().to_owned());
    }
    if let Some(encoding) = wide(bytes) {
        return whole(encoding, bytes, encoding.name().to_owned());
    }
    if let Some(at) = bytes.iter().position(|&b| b == 0) {
        let row = bytes[..at].iter().filter(|&&b| b == b'\n').count() + 1;
        return Err(format!("this is no text file: row {row} has a byte of value zero"));
    }
    let encoding = if std::str::from_utf8(bytes).is_ok() { UTF_8 } else { legacy(bytes) };
    whole(encoding, bytes, encoding.name().to_owned())
}

fn whole(encoding: &'static Encoding, bytes: &[u8], name: String) -> Result<Decoded, String> {
    let (text, malformed) = encoding.decode_without_bom_handling(bytes);
    if malformed {
        return Err(format!("the text is not {name} throughout"));
    }
    if let Some(at) = text.find('\0') {
        let row = text[..at].matches('\n').count() + 1;
        return Err(format!("this is no text file: row {row} has a character of value zero"));
    }
    Ok(Decoded { text: text.into_owned(), name })
}

/// UTF-16 without its mark: digits, separators and line ends leave every other byte zero, always on the same side.
fn wide(bytes: &[u8]) -> Option<&'static Encoding> {
    // Fewer are a slip in a short file.
    const FEWEST: usize = 4;
    // A table of numbers has far more than a third of its characters in ASCII, and none of value zero.
    let sample = &bytes[..bytes.len().min(1 << 16) & !1];
    let zeros = |side: usize| sample.iter().skip(side).step_by(2).filter(|&&b| b == 0).count();
    let (even, odd) = (zeros(0), zeros(1));
    match (even, odd) {
        (0, n) if FEWEST <= n && sample.len() < 6 * n => Some(UTF_16LE),
        (n, 0) if FEWEST <= n && sample.len() < 6 * n => Some(UTF_16BE),
        _ => None,
    }
}

/// Windows-1251 or -1252: a word of letters beyond ASCII only is Cyrillic, one that mixes them with ASCII letters is Latin.
///
/// Where no letters decide, the two agree on what tables of measurements have (µ, °, ±, ·).
fn legacy(bytes: &[u8]) -> &'static Encoding {
    let beyond = |b: &u8| 0xC0 <= *b || *b == 0xA8 || *b == 0xB8;
    let (mut cyrillic, mut latin) = (0_usize, 0_usize);
    for word in bytes.split(|b| !(b.is_ascii_alphabetic() || beyond(b))).filter(|word| word.iter().any(beyond)) {
        match word {
            // Words of one letter: х and у, the names of coordinates.
            [0xF5 | 0xF3 | 0xD5 | 0xD3] => cyrillic += 1,
            [_] => (),
            _ if word.iter().all(beyond) => cyrillic += 1,
            _ => latin += 1,
        }
    }
    if latin < cyrillic { WINDOWS_1251 } else { WINDOWS_1252 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(bytes: &[u8]) -> String {
        decode(bytes, None).map_or_else(|e| e, |d| d.name)
    }

    fn utf_16(text: &str, bytes: impl Fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(bytes).collect()
    }

    #[test]
    fn encodings_are_told_apart_by_their_bytes() {
        let text = "профиль;радиус, см\n1;20,5\n2;21,5\n";
        assert_eq!(name(text.as_bytes()), "UTF-8");
        assert_eq!(name(format!("\u{feff}{text}").as_bytes()), "UTF-8 with BOM");
        assert_eq!(name(&utf_16(text, u16::to_le_bytes)), "UTF-16LE");
        assert_eq!(name(&utf_16(text, u16::to_be_bytes)), "UTF-16BE");
        assert_eq!(name(&utf_16(&format!("\u{feff}{text}"), u16::to_be_bytes)), "UTF-16BE with BOM");
        assert_eq!(name(&WINDOWS_1251.encode(text).0), "windows-1251");
        assert_eq!(name(&WINDOWS_1251.encode("х, мм;у, мм\n1;2\n").0), "windows-1251");
        for latin in ["Stück;Größe µm\n1;2\n", "x µm;y µm\n1;2\n", "profil;numéro à côté\n", "Länge °C\n"] {
            assert_eq!(name(&WINDOWS_1252.encode(latin).0), "windows-1252", "{latin}");
        }
    }

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "радиус, см\n20,5\n";
        for bytes in [
            text.as_bytes().to_vec(),
            utf_16(text, u16::to_le_bytes),
            utf_16(text, u16::to_be_bytes),
            WINDOWS_1251.encode(text).0.into_owned(),
        ] {
            assert_eq!(decode(&bytes, None).expect("a text").text, text);
        }
        assert_eq!(decode(&[0xF0, 0xC1, 0xC4], Some("koi8-r")).expect("a text").text, "Пад");
    }

    #[test]
    fn bytes_of_value_zero_are_no_text() {
        assert!(name(b"x,y\n1,\0\n").contains("row 2"), "{}", name(b"x,y\n1,\0\n"));
        assert!(decode(b"x", Some("klingon")).unwrap_err().contains("klingon"));
        assert!(decode(b"\xff\xff", Some("utf-8")).is_err());
    }
}
