//! How many vertices a file has, by a look at its header or at the beginnings of its lines.

use mimesh_core::stage::{FileInput, ReadAt};

/// Bytes that hold a header.
const HEADER: usize = 1 << 16;

/// Bytes that are read at a time.
const PART: usize = 1 << 20;

/// The lines of an OBJ that begin with `v`.
pub fn of_obj(input: &dyn FileInput) -> Option<usize> {
    let file = input.open().ok()?;
    let length = file.length();
    let mut part = vec![0; PART];
    let (mut offset, mut count) = (0, 0);
    // What may come next to be a vertex: the blanks before its letter, the blank after it, or neither.
    let mut expected = Expected::Letter;
    while offset < length {
        let size = usize::try_from(length - offset).unwrap_or(PART).min(PART);
        file.read_at(offset, &mut part[..size]).ok()?;
        for &byte in &part[..size] {
            expected = match (byte, expected) {
                // Such a text is in another encoding.
                (0, _) => return None,
                (b'\n' | b'\r', _) => Expected::Letter,
                (b' ' | b'\t', Expected::Letter) => Expected::Letter,
                (b'v', Expected::Letter) => Expected::Blank,
                (b' ' | b'\t', Expected::Blank) => {
                    count += 1;
                    Expected::Nothing
                }
                _ => Expected::Nothing,
            };
        }
        offset += size as u64;
    }
    Some(count)
}

#[derive(Clone, Copy)]
enum Expected {
    Letter,
    Blank,
    Nothing,
}

/// What the header of a PLY says.
pub fn of_ply(input: &dyn FileInput) -> Option<usize> {
    let start = start(&*input.open().ok()?)?;
    let end = start.windows(10).position(|part| part == b"end_header")?;
    let header = std::str::from_utf8(&start[..end]).ok()?;
    let mut elements = header.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    elements.find_map(|words| match words[..] {
        ["element", "vertex", count] => count.parse().ok(),
        _ => None,
    })
}

/// The first number of an OFF in text.
pub fn of_off(input: &dyn FileInput) -> Option<usize> {
    let start = start(&*input.open().ok()?)?;
    let text = String::from_utf8_lossy(&start);
    let mut words = text.lines().map(|line| line.split('#').next().unwrap_or_default()).flat_map(str::split_whitespace);
    let first = words.next()?.trim_start_matches('\u{feff}');
    // Other variants have a dimension, or numbers in binary.
    let count = if matches!(first, "OFF" | "COFF" | "NOFF" | "CNOFF") { words.next()? } else { first };
    count.parse().ok()
}

fn start(file: &dyn ReadAt) -> Option<Vec<u8>> {
    let mut bytes = vec![0; usize::try_from(file.length()).unwrap_or(HEADER).min(HEADER)];
    file.read_at(0, &mut bytes).ok()?;
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use mimesh_core::stage::{BytesInput, Format, Selection};

    use crate::{Obj, Off, Ply};

    #[test]
    fn the_count_is_that_of_the_reader() {
        let obj = "# v 1 2 3\nv 0 0 0\n  v 1 0 0\r\nv\t0 1 0 # v\nvn 0 0 1\nvt 0 0\nv 9 9 \\\n 9\nf 1 2 3\n";
        let ply = "ply\nformat ascii 1.0\ncomment element vertex 9\nelement vertex 3\nproperty float x\nproperty float y\n\
            property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        let off = "OFF # 9 9 9\n# 8\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        let formats: [(Box<dyn Format>, &str, &str, usize); 3] = [
            (Box::new(Obj::default()), "a.obj", obj, 4),
            (Box::new(Ply::default()), "a.ply", ply, 3),
            (Box::new(Off::default()), "a.off", off, 3),
        ];
        for (format, name, text, count) in formats {
            let input = BytesInput::new(Path::new(name), text.to_owned());
            assert_eq!(format.vertex_count(&input), Some(count), "{name}");
            let read = format.read(&input, &Selection::default()).unwrap();
            assert_eq!(read.rest.positions.len(), count, "{name}");
        }
    }

    #[test]
    fn what_is_no_such_file_has_no_count() {
        let input = |bytes: &[u8]| BytesInput::new(Path::new("a"), bytes.to_vec());
        assert_eq!(Obj::default().vertex_count(&input(b"\xff\xfev\0 \0")), None);
        assert_eq!(Ply::default().vertex_count(&input(b"ply\nelement vertex x\nend_header\n")), None);
        assert_eq!(Off::default().vertex_count(&input(b"")), None);
    }
}
