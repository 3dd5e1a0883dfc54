//! The entries of elements, and the colours among their properties.

use mimesh_core::Result;

use super::{
    header::{Element, Property, Scalar},
    values::Values,
};
use crate::names::shown;

/// Reads every entry of `element` and gives `take` its number and each property with its values.
///
/// # Errors
///
/// [`Error::File`] if the file ends before.
pub fn for_each(element: &Element, values: &mut Values<'_>, mut take: impl FnMut(usize, usize, &[f64])) -> Result<()> {
    values.check_room(element)?;
    if element.properties.is_empty() {
        return Ok(());
    }
    let mut list = Vec::new();
    for entry in 0..element.count {
        for (number, property) in element.properties.iter().enumerate() {
            list.clear();
            let length = match property.list {
                Some(scalar) => length(values, scalar, property, element, entry)?,
                None => 1,
            };
            for _ in 0..length {
                list.push(values.next(property.scalar, &element.name, entry)?);
            }
            take(entry, number, &list);
        }
    }
    Ok(())
}

/// The length of a list.
fn length(
    values: &mut Values<'_>,
    scalar: Scalar,
    property: &Property,
    element: &Element,
    entry: usize,
) -> Result<usize> {
    let length = values.next(scalar, &element.name, entry)?;
    if length >= 0.0 && length.fract() == 0.0 {
        return Ok(length as usize);
    }
    let (list, of) = (shown(&property.name), &element.name);
    Err(values.wrong(format!(
        "the list `{list}` of {of} {entry} (from 0) has the length {length}: expected a whole number from 0"
    )))
}

/// The place of a property in a colour.
pub fn color_slot(name: &str) -> Option<usize> {
    Some(match name {
        "red" | "r" | "diffuse_red" => 0,
        "green" | "g" | "diffuse_green" => 1,
        "blue" | "b" | "diffuse_blue" => 2,
        "alpha" | "a" | "diffuse_alpha" => 3,
        _ => return None,
    })
}

/// The type of the colours of `element`, if it has red, green and blue of one.
pub fn color_type(element: &Element) -> Option<Scalar> {
    let of_slot = |slot: usize| {
        let mut found = element.properties.iter().filter(|p| p.list.is_none() && color_slot(&p.name) == Some(slot));
        found.next().map(|property| property.scalar)
    };
    let red = of_slot(0)?;
    (of_slot(1) == Some(red) && of_slot(2) == Some(red) && red.full().is_some()).then_some(red)
}

/// A part of a colour, which is 0 to 1.
pub fn unit(x: f64) -> f64 {
    if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 }
}
