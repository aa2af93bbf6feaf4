//! Archives: the zip file that an XLSX or ODS workbook is → the same parts, unpacked within a bound, none of them compressed any more.
//!
//! Sizes that an archive states about itself may lie. What is handed on has been unpacked and counted, so no reader behind can be made to unpack
//! more than that.

use std::io::Read;

use flate2::Crc;
use flate2::read::DeflateDecoder;

/// All parts of a workbook together, unpacked, are at most this large. Bytes.
const LARGEST: usize = 1 << 28;
/// More parts than this are no workbook.
const MOST_PARTS: usize = 10_000;

const LOCAL: u32 = 0x0403_4b50;
const CENTRAL: u32 = 0x0201_4b50;
const END: u32 = 0x0605_4b50;

/// A repacked archive.
pub(super) struct Archive {
    /// A zip file of the XML parts only, stored.
    pub bytes: Vec<u8>,
    /// Name and place in `bytes` of every part.
    pub parts: Vec<(String, std::ops::Range<usize>)>,
}

impl Archive {
    pub(super) fn part(&self, name: &str) -> Option<&[u8]> {
        self.parts.iter().find(|(part, _)| part == name).map(|(_, place)| &self.bytes[place.clone()])
    }
}

/// Unpacks and repacks; pictures and other parts that hold no cells are left out.
///
/// # Errors
/// The problem, as a sentence.
pub(super) fn repack(zip: &[u8]) -> Result<Archive, String> {
    let broken = || "the workbook is damaged: its parts cannot be found".to_owned();
    let end = (0..zip.len().saturating_sub(21)).rev().take(1 << 17).find(|&at| u32_at(zip, at) == Some(END)).ok_or_else(broken)?;
    let count = u16_at(zip, end + 10).ok_or_else(broken)? as usize;
    let mut at = u32_at(zip, end + 16).ok_or_else(broken)? as usize;
    if MOST_PARTS < count {
        return Err(format!("the workbook has {count} parts; at most {MOST_PARTS} are read"));
    }
    let mut archive = Archive { bytes: Vec::new(), parts: Vec::new() };
    let mut directory = Vec::new();
    for _ in 0..count {
        if u32_at(zip, at) != Some(CENTRAL) {
            return Err(broken());
        }
        let field = |offset: usize| u16_at(zip, at + offset).map(usize::from).ok_or_else(broken);
        let (flags, method) = (field(8)?, field(10)?);
        let packed = u32_at(zip, at + 20).ok_or_else(broken)? as usize;
        let (name_length, extra, comment) = (field(28)?, field(30)?, field(32)?);
        let local = u32_at(zip, at + 42).ok_or_else(broken)? as usize;
        let name = zip.get(at + 46..at + 46 + name_length).ok_or_else(broken)?;
        at += 46 + name_length + extra + comment;
        let name = String::from_utf8_lossy(name).replace('\\', "/");
        let cells = name.ends_with(".xml") || name.ends_with(".rels") || name == "mimetype";
        if !cells {
            continue;
        }
        if flags & 1 == 1 {
            return Err("the workbook is protected by a password".into());
        }
        if u32_at(zip, local) != Some(LOCAL) {
            return Err(broken());
        }
        let skip = |offset: usize| u16_at(zip, local + offset).map(usize::from).ok_or_else(broken);
        let start = local + 30 + skip(26)? + skip(28)?;
        let data = zip.get(start..start.saturating_add(packed)).ok_or_else(broken)?;
        append(&mut archive, &mut directory, name, method, data)?;
    }
    let start = archive.bytes.len();
    let count = (archive.parts.len() as u16).to_le_bytes();
    archive.bytes.extend_from_slice(&directory);
    let (length, start) = ((directory.len() as u32).to_le_bytes(), (start as u32).to_le_bytes());
    archive.bytes.extend(END.to_le_bytes().into_iter().chain([0; 4]).chain(count).chain(count).chain(length).chain(start).chain([0; 2]));
    Ok(archive)
}

/// Unpacks one part behind the others.
fn append(archive: &mut Archive, directory: &mut Vec<u8>, name: String, method: usize, data: &[u8]) -> Result<(), String> {
    let header = archive.bytes.len();
    let start = header + 30 + name.len();
    archive.bytes.resize(start, 0);
    let left = LARGEST.saturating_sub(start) as u64;
    let unpacked = match method {
        0 => data.take(left + 1).read_to_end(&mut archive.bytes),
        8 => DeflateDecoder::new(data).take(left + 1).read_to_end(&mut archive.bytes),
        _ => return Err(format!("the part “{name}” of the workbook is packed in a way that is not known here")),
    };
    unpacked.map_err(|e| format!("the part “{name}” of the workbook cannot be unpacked ({e})"))?;
    if LARGEST < archive.bytes.len() {
        return Err(format!("the workbook unpacks to more than {} MiB", LARGEST >> 20));
    }
    let mut sum = Crc::new();
    sum.update(&archive.bytes[start..]);
    let size = ((archive.bytes.len() - start) as u32).to_le_bytes();
    // What local and central header share: version, flag of UTF-8 names, stored, 1 January 1980, sum, sizes, length of the name, no extra.
    let mut shared = vec![20, 0, 0, 8, 0, 0, 0, 0, 0x21, 0];
    shared.extend(sum.sum().to_le_bytes().into_iter().chain(size).chain(size).chain((name.len() as u16).to_le_bytes()).chain([0, 0]));
    archive.bytes[header..header + 4].copy_from_slice(&LOCAL.to_le_bytes());
    archive.bytes[header + 4..header + 30].copy_from_slice(&shared);
    archive.bytes[header + 30..start].copy_from_slice(name.as_bytes());
    directory.extend(CENTRAL.to_le_bytes().into_iter().chain([20, 0]).chain(shared).chain([0; 10]));
    directory.extend((header as u32).to_le_bytes());
    directory.extend_from_slice(name.as_bytes());
    archive.parts.push((name, start..archive.bytes.len()));
    Ok(())
}

pub(super) fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..at.checked_add(2)?)?.try_into().ok().map(u16::from_le_bytes)
}

pub(super) fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at.checked_add(4)?)?.try_into().ok().map(u32::from_le_bytes)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::DeflateEncoder;

    use super::*;

    /// A zip file of one deflated part that states whatever size it likes.
    fn zip(name: &str, content: &[u8], stated: u32) -> Vec<u8> {
        let mut packer = DeflateEncoder::new(Vec::new(), Compression::best());
        packer.write_all(content).expect("memory");
        let packed = packer.finish().expect("memory");
        let mut shared = vec![20, 0, 0, 0, 8, 0, 0, 0, 0, 0];
        let mut sum = Crc::new();
        sum.update(content);
        shared.extend(sum.sum().to_le_bytes().into_iter().chain((packed.len() as u32).to_le_bytes()).chain(stated.to_le_bytes()));
        shared.extend((name.len() as u16).to_le_bytes().into_iter().chain([0, 0]));
        let mut zip: Vec<u8> = LOCAL.to_le_bytes().into_iter().chain(shared.clone()).chain(name.bytes()).collect();
        zip.extend(packed);
        let start = zip.len() as u32;
        zip.extend(CENTRAL.to_le_bytes().into_iter().chain([20, 0]).chain(shared).chain([0; 14]).chain(name.bytes()));
        let length = zip.len() as u32 - start;
        zip.extend(END.to_le_bytes().into_iter().chain([0, 0, 0, 0, 1, 0, 1, 0]));
        zip.extend(length.to_le_bytes().into_iter().chain(start.to_le_bytes()).chain([0, 0]));
        zip
    }

    #[test]
    fn parts_survive_the_repacking_and_a_second_one() {
        let once = repack(&zip("content.xml", b"<a/>", 4)).expect("a zip");
        let twice = repack(&once.bytes).expect("a zip");
        assert_eq!(once.part("content.xml"), Some(&b"<a/>"[..]));
        assert_eq!(once.bytes, twice.bytes);
    }

    #[test]
    fn a_bomb_that_lies_about_its_size_is_refused() {
        let bomb = zip("content.xml", &vec![b' '; LARGEST + 1], 10);
        assert!(bomb.len() < LARGEST / 500);
        assert!(repack(&bomb).err().expect("refused").contains("unpacks to more than 256 MiB"));
    }

    #[test]
    fn damage_is_a_sentence() {
        let sound = zip("content.xml", b"<a>0123456789</a>", 17);
        for cut in 0..sound.len() {
            assert!(repack(&sound[..cut]).is_err(), "{cut}");
        }
    }
}
