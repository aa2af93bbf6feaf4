//! Hostile input: whatever a file holds, every reader ends, in time, without panic, within a stated amount of memory.
//!
//! The kept corpus (fuzz/corpus), files made to hurt, and seeded mutations of all of them. HEMLINE_HOSTILE_ROUNDS sets the number of mutations of each
//! file, HEMLINE_HOSTILE_SEED their seed, HEMLINE_HOSTILE_READER one reader. One test, because memory is counted for the whole process.

use std::alloc::{GlobalAlloc, Layout, System};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use hemline::experiment::campaign::{Meshes, PictureScale, Pictures};
use hemline::import::{self, image, mesh, numbers, table};
use hemline::units::Metre;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::io::Write;

/// A reader that has not ended by then hangs: the slowest input takes two seconds, nine on a machine ten times overloaded.
const PATIENCE: Duration = Duration::from_secs(60);
/// What any reader may use for itself …
const BASE: usize = 64 << 20;
/// … and for every byte of its input: two digits and a comma become a cell, a coordinate, its row; a million columns take eleven.
const FOR_EACH_BYTE: usize = 50;
/// A picture's size stands in its header, not in its bytes: 20 000 px a side and 1 GiB decoded are allowed, and its greys and marks come on top.
const PICTURE: usize = 4 << 30;

/// A packed table may unpack to 256 MiB (docs/import.md); its text, its cells and its numbers are there at the same time.
const UNPACKED: usize = 768 << 20;

/// Counts bytes in use, and the most there were.
struct Counting;

static USED: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

fn taken(bytes: usize) {
    let used = USED.fetch_add(bytes, Ordering::Relaxed) + bytes;
    MOST.fetch_max(used, Ordering::Relaxed);
}

// SAFETY: every call goes to the system's allocator unchanged; only counters are kept beside it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        taken(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        taken(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        USED.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        taken(size);
        USED.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// One reader: the folder of its corpus, and what it does with a file. Returns whether the file was taken.
struct Reader {
    name: &'static str,
    read: fn(&Path) -> bool,
    /// Bytes of memory allowed for an input of so many bytes.
    allowed: fn(usize) -> usize,
}

const READERS: [Reader; 6] = [
    Reader { name: "table", read: |path| table::profiles(path).is_ok(), allowed: |bytes| UNPACKED + usual(bytes) },
    Reader { name: "numbers", read: |path| numbers::NumberTable::read(path).is_ok(), allowed: usual },
    Reader { name: "image", read: read_image, allowed: |bytes| PICTURE + usual(bytes) },
    Reader { name: "mesh", read: read_mesh, allowed: usual },
    Reader { name: "campaign", read: |path| beside(path, "campaign.toml", "design/small.csv", "design.csv"), allowed: usual },
    Reader { name: "design", read: |path| beside(path, "design.csv", "campaign/small.toml", "campaign.toml"), allowed: usual },
];

fn usual(bytes: usize) -> usize {
    BASE + FOR_EACH_BYTE * bytes
}

fn read_image(path: &Path) -> bool {
    image::outline(path, &Pictures::of_scale(PictureScale::Pixel(Metre(1e-3)))).is_ok()
}

fn read_mesh(path: &Path) -> bool {
    let asked = Meshes { axis: Some([0.0, 0.0, 1.0]), unit: Some(Metre(1e-3)) };
    let mut taken = mesh::hem(path, &mesh::Options::default()).is_ok();
    for options in [mesh::Options::default(), mesh::Options { frame: asked, ..mesh::Options::default() }] {
        if let Ok(mesh) = mesh::read(path, &options) {
            let cuts: Vec<mesh::Cut> = mesh.heights(4).into_iter().map(|height| mesh.cut(height)).collect();
            mesh.measured(&cuts);
            taken = true;
        }
    }
    taken
}

/// A campaign folder of which one file is hostile.
fn beside(path: &Path, name: &str, sound: &str, sound_name: &str) -> bool {
    let folder = path.parent().expect("a folder").join("campaign");
    fs::create_dir_all(folder.join("profiles")).expect("writable");
    fs::copy(path, folder.join(name)).expect("copied");
    fs::copy(corpus().join(sound), folder.join(sound_name)).expect("copied");
    for profile in ["profiles/a.csv", "profiles/b.csv"] {
        fs::copy(corpus().join("table/comma.csv"), folder.join(profile)).expect("copied");
    }
    import::load(&folder).is_ok()
}

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus")
}

/// A number from the environment.
fn asked(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// One input: its name (the extension counts) and its bytes.
type Input = (String, Vec<u8>);

#[test]
fn every_reader_ends_in_time_without_panic_and_within_its_memory() {
    let (rounds, seed) = (asked("HEMLINE_HOSTILE_ROUNDS", 12), asked("HEMLINE_HOSTILE_SEED", 1));
    let only = std::env::var("HEMLINE_HOSTILE_READER").ok();
    let folder = tempfile::tempdir().expect("a folder");
    let mut faults: Vec<String> = Vec::new();
    for reader in READERS.iter().filter(|reader| only.as_deref().is_none_or(|name| name == reader.name)) {
        let mut inputs = kept(reader.name);
        assert!(!inputs.is_empty(), "no corpus for {}", reader.name);
        let seeds = inputs.clone();
        inputs.extend(made(reader.name));
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (mut tried, mut accepted, mut most, mut slowest) = (0_usize, 0_usize, 0_usize, (Duration::ZERO, String::new()));
        let mut check = |(name, bytes): &Input| {
            let path = folder.path().join(name);
            fs::write(&path, bytes).expect("writable");
            let begun = Instant::now();
            let outcome = watched(reader, &path);
            let took = begun.elapsed();
            fs::remove_file(&path).expect("removable");
            tried += 1;
            if slowest.0 < took {
                slowest = (took, name.clone());
            }
            let fault = match outcome {
                Ended::Panicked => "panic".into(),
                Ended::Hangs => "no end".into(),
                Ended::Used { bytes: used, taken } => {
                    accepted += usize::from(taken);
                    most = most.max(used);
                    if used <= (reader.allowed)(bytes.len()) {
                        return true;
                    }
                    format!("{} MB for {} bytes", used >> 20, bytes.len())
                }
            };
            let kept = std::env::temp_dir().join(format!("hemline-hostile-{}-{tried}-{name}", reader.name));
            fs::write(&kept, bytes).expect("writable");
            faults.push(format!("{}: {fault}: {}", reader.name, kept.display()));
            fault != "no end"
        };
        // After a hang its thread still runs and counts: nothing more can be told of this reader.
        let whole = inputs.iter().all(&mut check)
            && (0..rounds).all(|_| {
                (0..seeds.len()).all(|i| {
                    let input = (seeds[i].0.clone(), mutated(&seeds, i, &mut random));
                    check(&input)
                })
            });
        println!(
            "{}: {tried} inputs, {accepted} taken, most memory {} MB, slowest {:.2} s ({}){}",
            reader.name,
            most >> 20,
            slowest.0.as_secs_f64(),
            slowest.1,
            if whole { "" } else { ", stopped" }
        );
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

enum Ended {
    Used { bytes: usize, taken: bool },
    Panicked,
    Hangs,
}

/// Runs a reader in a thread of its own.
fn watched(reader: &Reader, path: &Path) -> Ended {
    let (send, receive) = mpsc::channel();
    let (read, path) = (reader.read, path.to_path_buf());
    let before = USED.load(Ordering::Relaxed);
    MOST.store(before, Ordering::Relaxed);
    let thread = std::thread::spawn(move || {
        let taken = read(&path);
        // A receiver that has given up does not care.
        send.send(taken).unwrap_or_default();
    });
    match receive.recv_timeout(PATIENCE) {
        Ok(taken) => {
            thread.join().expect("it has sent its answer");
            Ended::Used { bytes: MOST.load(Ordering::Relaxed).saturating_sub(before), taken }
        }
        Err(mpsc::RecvTimeoutError::Disconnected) => Ended::Panicked,
        Err(mpsc::RecvTimeoutError::Timeout) => Ended::Hangs,
    }
}

/// The files of a reader's corpus, by name.
fn kept(reader: &str) -> Vec<Input> {
    let mut paths: Vec<PathBuf> =
        fs::read_dir(corpus().join(reader)).expect("a corpus").map(|entry| entry.expect("readable").path()).collect();
    paths.sort();
    paths.iter().map(|path| (path.file_name().expect("a name").to_string_lossy().into_owned(), fs::read(path).expect("readable"))).collect()
}

/// One input, changed in one to six places: bits, bytes, extreme numbers, cuts, repeats, pieces of other inputs, digits.
fn mutated(seeds: &[Input], of: usize, random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = seeds[of].1.clone();
    for _ in 0..random.random_range(1..=6) {
        if bytes.is_empty() {
            return bytes;
        }
        let at = random.random_range(0..bytes.len());
        // Headers are short and decide most.
        let at = if random.random_bool(0.4) { at % 256.min(bytes.len()) } else { at };
        let length = random.random_range(1..=64.min(bytes.len() - at));
        match random.random_range(0..9) {
            0 => bytes[at] ^= 1 << random.random_range(0..8),
            1 => bytes[at] = random.random(),
            2 => {
                let extreme = [0_u64, 1, 0x7fff_ffff, 0xffff_ffff, u64::MAX, 1 << 40][random.random_range(0..6)];
                let raw = if random.random_bool(0.5) { extreme.to_le_bytes() } else { extreme.to_be_bytes() };
                let width = [1, 2, 4, 8][random.random_range(0..4)].min(bytes.len() - at);
                bytes[at..at + width].copy_from_slice(&raw[..width]);
            }
            3 => bytes.truncate(at),
            4 => {
                bytes.drain(at..at + length);
            }
            5 => {
                let piece = bytes[at..at + length].to_vec();
                let times = random.random_range(1..=50);
                (0..times).for_each(|_| drop(bytes.splice(at..at, piece.iter().copied())));
            }
            6 => {
                let other = &seeds[random.random_range(0..seeds.len())].1;
                if !other.is_empty() {
                    let from = random.random_range(0..other.len());
                    let to = (from + random.random_range(1..=400)).min(other.len());
                    drop(bytes.splice(at..at + length, other[from..to].iter().copied()));
                }
            }
            7 => {
                // A number in a text becomes another.
                let from = (at..bytes.len()).find(|&i| bytes[i].is_ascii_digit());
                if let Some(from) = from {
                    let to = (from..bytes.len()).find(|&i| !bytes[i].is_ascii_digit()).unwrap_or(bytes.len());
                    let texts = ["0", "-1", "4294967295", "1000000000000", "1e308", "nan", "inf", "1e-320", "99999999999999999999", ""];
                    drop(bytes.splice(from..to, texts[random.random_range(0..texts.len())].bytes()));
                }
            }
            _ => {
                let texts = ["\n", "\r", ",", ";", "\t", "\"", "\0", " ", "\u{feff}", "{", "[", "[[", "]", "=", "#", "é", "\u{202e}"];
                drop(bytes.splice(at..at, texts[random.random_range(0..texts.len())].bytes()));
            }
        }
    }
    bytes
}

/// Files made to hurt.
fn made(reader: &str) -> Vec<Input> {
    let text = |name: &str, text: String| (name.to_owned(), text.into_bytes());
    match reader {
        "table" | "numbers" => {
            let wide: String = (0..1_000_000).map(|i| format!("c{i},")).collect();
            let row = "1,".repeat(1_000_000);
            let bomb = gzip(&vec![b'1'; 256 << 20]);
            let mut inputs = vec![
                ("empty.csv".into(), vec![]),
                text("columns.csv", format!("x_cm,y_cm,{wide}\n{row}\n{row}\n")),
                text("quotes.csv", "x_cm,y_cm\n\"".to_owned() + &"\"\"".repeat(500_000)),
                text("one_line.csv", "x_cm,y_cm\n".to_owned() + &"1".repeat(2_000_000)),
                text("rows.csv", "x_cm,y_cm\n".to_owned() + &"\n".repeat(2_000_000)),
                text("names.csv", "run,x_cm,y_cm\n".to_owned() + &(0..50_000).map(|i| format!("r{i},1,2\n")).collect::<String>()),
                text("line.csv", "x_cm,y_cm\n".to_owned() + &(0..100_000).map(|i| format!("{},{}\n", i % 997, i % 991)).collect::<String>()),
                text("formula.csv", "x_cm,y_cm\n=cmd|' /C calc'!A0,=HYPERLINK(\"http://x\")\n".to_owned()),
                ("nul.csv".into(), vec![0; 100_000]),
                ("high.csv".into(), vec![0xff; 100_000]),
            ];
            if reader == "table" {
                inputs.extend([
                    ("bomb.csv.gz".to_owned(), bomb.clone()),
                    ("bomb.gz".to_owned(), bomb),
                    ("bomb.xlsx".to_owned(), zip(&[("[Content_Types].xml", &[b' '; 1000]), ("xl/workbook.xml", &vec![b' '; 256 << 20])])),
                    ("bomb.ods".to_owned(), zip(&[("mimetype", b"application/vnd.oasis.opendocument.spreadsheet"), ("content.xml", &vec![b' '; 256 << 20])])),
                    ("cut.parquet".to_owned(), b"PAR1\xff\xff\xff\x7fPAR1".to_vec()),
                    ("cut.arrow".to_owned(), b"ARROW1\0\0\xff\xff\xff\xff\xff\xff\xff\x7f".to_vec()),
                ]);
            }
            inputs
        }
        "image" => vec![
            ("huge.png".into(), png(1_000_000_000, 1_000_000_000, &[])),
            ("large.png".into(), png(20_000, 20_000, &[])),
            ("broad.png".into(), png(2_000_000_000, 1, &[])),
            ("bomb.png".into(), png(6_000, 6_000, &vec![0; 6_001 * 6_000])),
            ("zero.png".into(), png(0, 0, &[])),
            ("huge.bmp".into(), bmp(1_000_000_000, 1_000_000_000)),
            ("huge.tif".into(), tiff(1_000_000_000)),
            ("empty.jpg".into(), vec![]),
        ],
        "mesh" => meshes(),
        "campaign" => vec![
            text("deep.toml", "a = ".to_owned() + &"[".repeat(100_000)),
            text("tables.toml", "[a".to_owned() + &".a".repeat(100_000) + "]"),
            text("dots.toml", "a".to_owned() + &".a".repeat(100_000) + " = 1"),
            text("inline.toml", "a = ".to_owned() + &"{a=".repeat(100_000)),
            text("factors.toml", "title=\"a\"\norigin=\"a\"\napparatus=\"skirt\"\n".to_owned() + &"[[factors]]\nname=\"a\"\nlow=0\nhigh=1\n".repeat(2_000)),
            text("string.toml", "title = \"".to_owned() + &"\\u0041".repeat(100_000)),
        ],
        _ => vec![
            text("paths.csv", "run,replicate,stiff,areal_density_g_m2,hem_radius_cm,profile\n1,1,-1,150,20,/dev/zero\n2,1,1,150,20,../../../../etc/passwd\n".into()),
            text("runs.csv", "run,replicate,stiff,areal_density_g_m2,hem_radius_cm,profile\n".to_owned() + &(0..5_000).map(|i| format!("{i},1,-1,150,20,profiles/a.csv\n")).collect::<String>()),
            text("same.csv", "run,replicate,stiff,areal_density_g_m2,hem_radius_cm,profile\n".to_owned() + &"1,1,-1,150,20,profiles/a.csv\n".repeat(5_000)),
        ],
    }
}

fn meshes() -> Vec<Input> {
    let text = |name: &str, text: String| (name.to_owned(), text.into_bytes());
    let ply = |format: &str, vertices: &str, faces: &str, rest: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n{rest}"
        )
    };
    let mut stl = vec![b' '; 84];
    stl[80..].copy_from_slice(&u32::MAX.to_le_bytes());
    let glb = |length: u32, json: u32| {
        [b"glTF".as_slice(), &2_u32.to_le_bytes(), &length.to_le_bytes(), &json.to_le_bytes(), b"JSON", b"{}"].concat()
    };
    let gltf = |nodes: &str, more: &str| {
        format!("{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{nodes}]{more}}}")
    };
    let chain: String = (1..50_000).map(|i| format!("{{\"children\":[{i}]}},")).collect::<String>() + "{}";
    // Every triangle apart from every other: nothing but open ends.
    let soup: String = (0..20_000)
        .map(|i| format!("v {} {} 0\nv {} {} 100\nv {} {} 50\nf -3 -2 -1\n", i % 141, i / 141, i % 141, i / 141, i % 141 + 1, i / 141))
        .collect();
    // Many sheets on one edge, and one polygon with very many corners, not convex.
    let book: String = "v 0 0 0\nv 0 0 100\n".to_owned()
        + &(0..20_000).map(|i| format!("v {} {} 50\nf 1 2 -1\n", i % 200 + 1, i / 200)).collect::<String>();
    let comb: String = (0..20_000).map(|i| format!("v {} {} {}\n", i, if i % 2 == 0 { 0 } else { 100 }, i % 3)).collect::<String>()
        + "f"
        + &(1..=20_000).map(|i| format!(" {i}")).collect::<String>();
    vec![
        text("count.ply", ply("ascii", "1000000000000", "1000000000000", "0 0 0\n")),
        text("count_binary.ply", ply("binary_little_endian", "1000000000000", "1000000000000", "abc")),
        text("count_faces.ply", ply("binary_big_endian", "0", "99999999999999999999", "abc")),
        text("no_properties.ply", "ply\nformat binary_little_endian 1.0\nelement vertex 1000000000000\nend_header\n".into()),
        text("no_rows.ply", "ply\nformat ascii 1.0\nelement nothing 1000000000000\nend_header\n".into()),
        text("list.ply", "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list uint double vertex_indices\nend_header\n\u{1}\u{1}\u{1}\u{1}".into()),
        text("range.ply", ply("ascii", "3", "1", "0 0 0\n1 0 0\n0 1 0\n3 0 1 77\n")),
        text("negative.ply", ply("ascii", "3", "1", "0 0 0\n1 0 0\n0 1 0\n3 0 -1 2\n")),
        text("comment.ply", "ply\nformat ascii 1.0\ncomment ".to_owned() + &"x".repeat(3_000_000)),
        text("properties.ply", "ply\nformat ascii 1.0\nelement vertex 1\n".to_owned() + &(0..50_000).map(|i| format!("property float p{i}\n")).collect::<String>() + "end_header\n"),
        ("count.stl".into(), stl),
        text("solid.stl", "solid ".to_owned() + &"x".repeat(3_000_000)),
        text("endless.stl", "solid a\n".to_owned() + &"facet normal 0 0 0\n".repeat(100_000)),
        text("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 999999999999\n".into()),
        text("relative.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -9223372036854775808\n".into()),
        text("texture.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/18446744073709551615/1 2/1/9223372036854775807 3/-9/-9\n".into()),
        text("material.obj", "mtllib /etc/passwd ../../x.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".into()),
        text("extreme.obj", "v 1e308 1e308 1e308\nv -1e308 0 0\nv 0 -1e308 0\nf 1 2 3\n".into()),
        text("tiny.obj", "v 1e-320 0 0\nv 0 1e-320 0\nv 0 0 1e-320\nf 1 2 3\n".into()),
        text("objects.obj", "o a\nv 0 0 0\nf 1 1 1\n".repeat(20_000)),
        text("soup.obj", soup),
        text("book.obj", book),
        text("comb.obj", comb),
        ("length.glb".into(), glb(u32::MAX, 2)),
        ("short.glb".into(), glb(0, 2)),
        ("chunk.glb".into(), glb(22, u32::MAX)),
        text("deep.gltf", "[".repeat(1_000_000)),
        text("chain.gltf", gltf(&chain, "")),
        text("circle.gltf", gltf("{\"children\":[1]},{\"children\":[0]}", "")),
        text("self.gltf", gltf("{\"children\":[0]}", "")),
        text("doubling.gltf", gltf(&((1..40).map(|i| format!("{{\"children\":[{i},{i}]}},")).collect::<String>() + "{}"), "")),
        text("count.gltf", gltf("{\"mesh\":0}", ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,\"count\":1000000000000,\"componentType\":5126,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,1]}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":1000000000000}],\"buffers\":[{\"byteLength\":1000000000000,\"uri\":\"data:application/octet-stream;base64,AAAA\"}]")),
        text("overflow.gltf", gltf("{\"mesh\":0}", ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,\"byteOffset\":18446744073709551615,\"count\":2,\"componentType\":5126,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,1]}],\"bufferViews\":[{\"buffer\":0,\"byteOffset\":18446744073709551615,\"byteLength\":3,\"byteStride\":4}],\"buffers\":[{\"byteLength\":3,\"uri\":\"data:application/octet-stream;base64,AAAA\"}]")),
        text("outside.gltf", gltf("{}", ",\"buffers\":[{\"byteLength\":10,\"uri\":\"file:///etc/passwd\"}]")),
        text("zero.gltf", gltf("{\"mesh\":0}", ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"mode\":6}]}],\"accessors\":[{\"bufferView\":0,\"count\":0,\"componentType\":5126,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,1]}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":3}],\"buffers\":[{\"byteLength\":3,\"uri\":\"data:application/octet-stream;base64,AAAA\"}]")),
    ]
}

fn gzip(content: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(content).expect("memory");
    encoder.finish().expect("memory")
}

/// A PNG of 8-bit greys whose header states a size; the raw rows may be fewer.
fn png(width: u32, height: u32, rows: &[u8]) -> Vec<u8> {
    let chunk = |kind: &[u8], content: &[u8]| {
        let mut sum = flate2::Crc::new();
        sum.update(kind);
        sum.update(content);
        [&(content.len() as u32).to_be_bytes(), kind, content, &sum.sum().to_be_bytes()].concat()
    };
    let header = [width.to_be_bytes().as_slice(), &height.to_be_bytes(), &[8, 0, 0, 0, 0]].concat();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(rows).expect("memory");
    let data = encoder.finish().expect("memory");
    [b"\x89PNG\r\n\x1a\n".as_slice(), &chunk(b"IHDR", &header), &chunk(b"IDAT", &data), &chunk(b"IEND", &[])].concat()
}

fn bmp(width: i32, height: i32) -> Vec<u8> {
    let file = [b"BM".as_slice(), &54_u32.to_le_bytes(), &[0; 4], &54_u32.to_le_bytes()].concat();
    let header = [
        40_u32.to_le_bytes().as_slice(),
        &width.to_le_bytes(),
        &height.to_le_bytes(),
        &1_u16.to_le_bytes(),
        &24_u16.to_le_bytes(),
        &[0; 24],
    ]
    .concat();
    [file, header].concat()
}

fn tiff(side: u32) -> Vec<u8> {
    // Width, height, bits, compression none, black is zero, one strip at 8, rows and bytes of it.
    let entries = [(256, side), (257, side), (258, 8), (259, 1), (262, 1), (273, 8), (278, side), (279, side)];
    let mut bytes = [b"II".as_slice(), &42_u16.to_le_bytes(), &8_u32.to_le_bytes(), &(entries.len() as u16).to_le_bytes()].concat();
    for (tag, value) in entries {
        bytes
            .extend([(tag as u16).to_le_bytes().as_slice(), &4_u16.to_le_bytes(), &1_u32.to_le_bytes(), &u32::to_le_bytes(value)].concat());
    }
    bytes.extend([0; 4]);
    bytes
}

/// A zip archive: local headers, deflated content, central directory.
fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in files {
        let mut sum = flate2::Crc::new();
        sum.update(content);
        let mut encoder = flate2::write::DeflateEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(content).expect("memory");
        let packed = encoder.finish().expect("memory");
        let common = [
            20_u16.to_le_bytes().as_slice(),
            &[0, 0],
            &8_u16.to_le_bytes(),
            &[0; 4],
            &sum.sum().to_le_bytes(),
            &(packed.len() as u32).to_le_bytes(),
            &(content.len() as u32).to_le_bytes(),
            &(name.len() as u16).to_le_bytes(),
            &[0, 0],
        ]
        .concat();
        let offset = (bytes.len() as u32).to_le_bytes();
        directory.extend([b"PK\x01\x02\x14\0".as_slice(), &common, &[0; 10], &offset, name.as_bytes()].concat());
        bytes.extend([b"PK\x03\x04".as_slice(), &common, name.as_bytes(), &packed].concat());
    }
    let (count, size, offset) =
        ((files.len() as u16).to_le_bytes(), (directory.len() as u32).to_le_bytes(), (bytes.len() as u32).to_le_bytes());
    bytes.extend(&directory);
    bytes.extend([b"PK\x05\x06\0\0\0\0".as_slice(), &count, &count, &size, &offset, &[0, 0]].concat());
    bytes
}
