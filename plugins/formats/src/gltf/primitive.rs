//! Triangles of the primitive modes that have any.

/// The triangles of a primitive in mode 4 (triangles), 5 (strip) or 6 (fan) with these corners, all turning alike.
///
/// Triangles with a repeated corner, which only join strips, are left out of strips and fans.
///
/// # Errors
///
/// If the corners do not make whole triangles, or there is no such mode.
pub fn triangles(mode: u32, corners: &[u32]) -> Result<Vec<[u32; 3]>, String> {
    let has_area = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    match mode {
        4 if corners.len().is_multiple_of(3) => Ok(corners.as_chunks().0.to_vec()),
        4 => Err(format!("{} corners do not make whole triangles", corners.len())),
        5 => {
            let strip = corners.array_windows().enumerate();
            Ok(strip.map(|(i, &[a, b, c])| if i % 2 == 0 { [a, b, c] } else { [a, c, b] }).filter(has_area).collect())
        }
        6 => {
            let Some((&hub, rim)) = corners.split_first() else { return Ok(Vec::new()) };
            Ok(rim.array_windows().map(|&[a, b]| [hub, a, b]).filter(has_area).collect())
        }
        _ => Err(format!("unknown mode {mode}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_turn_alike() {
        assert_eq!(triangles(4, &[0, 1, 2, 2, 1, 3]).unwrap(), [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(triangles(5, &[0, 1, 2, 3, 3, 4]).unwrap(), [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(triangles(6, &[9, 1, 2, 3]).unwrap(), [[9, 1, 2], [9, 2, 3]]);
        assert_eq!(triangles(4, &[0, 1]).unwrap_err(), "2 corners do not make whole triangles");
        assert_eq!(triangles(5, &[0]).unwrap(), [[0; 3]; 0]);
    }
}
