//! Placeholders in the names of files: `{pose}`, `{target}`, `{matrix}`, `{name}`.
//!
//! What the author of a pipeline writes may lead anywhere. What stands for a placeholder comes from files of strangers, and is a part of
//! one name: it never adds a folder and never leaves one.

/// What the file systems in use take for a name, in bytes.
pub const MAX_NAME: usize = 255;

/// The name of the placeholder for a pose.
pub const POSE: &str = "{pose}";

/// `pattern` with `{pose}` replaced by `name`, in which characters that file systems refuse become `_`, and so does a name that is
/// empty or has dots alone.
///
/// A name that Windows reserves gets a `_`, unless it is the pattern that makes it so: `CON` becomes `CON_.obj`.
pub fn with_pose(pattern: &str, name: &str) -> String {
    let name = name.replace(is_refused, "_");
    let name = if name.chars().all(|c| c == '.') { name.replace('.', "_") } else { name };
    let name = if name.is_empty() { "_".into() } else { name };
    let whole = pattern.replace(POSE, &name);
    if !is_reserved(file_name(&whole)) {
        return whole;
    }
    let (stem, rest) = name.split_at(name.find('.').unwrap_or(name.len()));
    let free = pattern.replace(POSE, &format!("{stem}_{rest}"));
    if is_reserved(file_name(&free)) { whole } else { free }
}

/// Whether some file system refuses `c` in a name, takes it for the end of a folder, or people cannot see it.
pub fn is_refused(c: char) -> bool {
    // Marks that turn the direction of writing, and breaks of lines.
    let is_unseen =
        matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}');
    c.is_control() || is_unseen || "/\\:*?\"<>|".contains(c)
}

/// Whether Windows refuses the name of a file: a device of that name, with any extension, or a dot or blank at the end.
pub fn is_reserved(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default().trim_end().to_uppercase();
    let is_device = matches!(stem.as_str(), "CON" | "PRN" | "AUX" | "NUL" | "CONIN$" | "CONOUT$");
    let numbered = ["COM", "LPT"].iter().filter_map(|device| stem.strip_prefix(device));
    let mut digits = numbered.map(|number| number.chars().collect::<Vec<_>>());
    let is_port = digits.any(|number| matches!(number[..], ['1'..='9' | '¹' | '²' | '³']));
    is_device || is_port || name.ends_with(['.', ' '])
}

fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// The placeholders in braces of `pattern`, without the braces.
pub fn placeholders(pattern: &str) -> Vec<&str> {
    pattern.split('{').skip(1).filter_map(|part| Some(part.split_once('}')?.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_poses_cannot_leave_the_folder() {
        let written = |name: &str| with_pose("out/{pose}.obj", name);
        assert_eq!(written("../a:b"), "out/.._a_b.obj");
        assert_eq!(["", ".", ".."].map(written), ["out/_.obj", "out/_.obj", "out/__.obj"]);
        assert_eq!(
            ["a\0b", "\u{202e}jbo", "a\nb", "/etc/x"].map(written),
            ["out/a_b.obj", "out/_jbo.obj", "out/a_b.obj", "out/_etc_x.obj"]
        );
        assert_eq!(["-rf", ".a", "größe 1"].map(written), ["out/-rf.obj", "out/.a.obj", "out/größe 1.obj"]);
    }

    #[test]
    fn devices_are_reserved_with_any_extension() {
        for reserved in ["con.obj", "NUL", "Aux.tar.gz", "com1.ply", "LPT9.obj", "COM².obj", "conin$.obj", "a.", "b "]
        {
            assert!(is_reserved(reserved), "{reserved}");
        }
        for fine in ["cone.obj", "com0.obj", "com10.obj", "a.con", ".con.obj", "con_.obj", "a .obj"] {
            assert!(!is_reserved(fine), "{fine}");
        }
    }

    #[test]
    fn reserved_names_become_others_where_the_pose_makes_them_so() {
        assert_eq!(with_pose("out/{pose}.obj", "CON"), "out/CON_.obj");
        assert_eq!(with_pose("out/{pose}.obj", "aux.smile"), "out/aux_.smile.obj");
        assert_eq!(with_pose("out/{pose}.obj", "nul "), "out/nul _.obj");
        assert_eq!(with_pose("out/pose-{pose}.obj", "CON"), "out/pose-CON.obj");
        assert_eq!(with_pose("con/{pose}.obj", "smile"), "con/smile.obj");
        assert_eq!(with_pose("con.{pose}.obj", "smile"), "con.smile.obj");
    }

    #[test]
    fn placeholders_are_found_in_order() {
        assert_eq!(placeholders("{a}/x{pose}.obj"), ["a", "pose"]);
    }
}
