//! Paths in journals, read with bounds.

use std::{fmt, marker::PhantomData, path::Path, path::PathBuf};

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{Error, SeqAccess, Visitor},
};

/// The most places of a journal.
pub(super) const MAX_PLACES: usize = 250_000;

/// The most bytes of a path that is read, twice as many as systems take.
const MAX_PATH_BYTES: usize = 8192;

/// A path. Those that are no Unicode are written as bytes.
#[derive(Serialize)]
#[serde(untagged)]
pub(super) enum PathText {
    Text(String),
    Bytes(Vec<u8>),
}

impl PathText {
    pub fn of(path: &Path) -> Self {
        match path.to_str() {
            Some(text) => Self::Text(text.into()),
            None => Self::Bytes(path.as_os_str().as_encoded_bytes().into()),
        }
    }

    #[cfg(unix)]
    pub fn path(self) -> Option<PathBuf> {
        use std::os::unix::ffi::OsStringExt;
        Some(match self {
            Self::Text(text) => text.into(),
            Self::Bytes(bytes) => std::ffi::OsString::from_vec(bytes).into(),
        })
    }

    /// Names that are no Unicode cannot be made from bytes on other systems.
    #[cfg(not(unix))]
    pub fn path(self) -> Option<PathBuf> {
        match self {
            Self::Text(text) => Some(text.into()),
            Self::Bytes(_) => None,
        }
    }
}

impl<'de> Deserialize<'de> for PathText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Path;
        impl<'de> Visitor<'de> for Path {
            type Value = PathText;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a path")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<PathText, E> {
                if text.len() > MAX_PATH_BYTES { Err(E::custom("too long")) } else { Ok(PathText::Text(text.into())) }
            }

            fn visit_seq<A: SeqAccess<'de>>(self, items: A) -> Result<PathText, A::Error> {
                up_to(MAX_PATH_BYTES, items).map(PathText::Bytes)
            }
        }
        deserializer.deserialize_any(Path)
    }
}

/// Reads a list of no more items than a journal has places.
pub(super) fn bounded<'de, T: Deserialize<'de>, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<T>, D::Error> {
    struct List<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> Visitor<'de> for List<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a list")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, items: A) -> Result<Vec<T>, A::Error> {
            up_to(MAX_PLACES, items)
        }
    }
    deserializer.deserialize_seq(List(PhantomData))
}

/// The items of a list, if they are no more than `limit`.
fn up_to<'de, T: Deserialize<'de>, A: SeqAccess<'de>>(limit: usize, mut items: A) -> Result<Vec<T>, A::Error> {
    let mut list = Vec::new();
    while let Some(item) = items.next_element()? {
        if list.len() == limit {
            return Err(A::Error::custom("too many items"));
        }
        list.push(item);
    }
    Ok(list)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Deserialize)]
    struct Listed {
        #[serde(deserialize_with = "bounded")]
        paths: Vec<PathText>,
    }

    #[test]
    fn what_is_read_is_bounded() {
        let read = |text: &str| serde_json::from_str::<Listed>(text).map(|read| read.paths.len()).ok();
        assert_eq!(read(r#"{ "paths": ["a", [98, 255]] }"#), Some(2));
        assert_eq!(read(&format!(r#"{{ "paths": ["{}"] }}"#, "x".repeat(MAX_PATH_BYTES + 1))), None);
        assert_eq!(read(&format!(r#"{{ "paths": [[1{}]] }}"#, ",1".repeat(MAX_PATH_BYTES))), None);
        assert_eq!(read(&format!(r#"{{ "paths": [""{}] }}"#, r#","""#.repeat(MAX_PLACES))), None);
        assert_eq!(read(&format!(r#"{{ "paths": [""{}] }}"#, r#","""#.repeat(MAX_PLACES - 1))), Some(MAX_PLACES));
    }
}
