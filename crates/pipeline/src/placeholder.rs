//! Placeholders in the names of files: `{pose}`, `{target}`, `{matrix}`, `{name}`.

/// The name of the placeholder for a pose.
pub const POSE: &str = "{pose}";

/// `pattern` with `{pose}` replaced by `name`, in which characters that file systems refuse become `_`.
pub fn with_pose(pattern: &str, name: &str) -> String {
    let refused = |c: char| c.is_control() || "/\\:*?\"<>|".contains(c);
    pattern.replace(POSE, &name.replace(refused, "_"))
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
        assert_eq!(with_pose("out/{pose}.obj", "../a:b"), "out/.._a_b.obj");
        assert_eq!(placeholders("{a}/x{pose}.obj"), ["a", "pose"]);
    }
}
