//! What browsers let a page do.

use base64::{Engine, prelude::BASE64_STANDARD};
use sha2::{Digest, Sha256};

/// Returns what a page may load and run: its own style and pictures, and of scripts the one given.
pub fn content_policy(script: Option<&str>) -> String {
    let own = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'";
    match script {
        Some(script) => format!("{own}; script-src {}", script_source(script)),
        None => own.into(),
    }
}

/// Returns how a policy names one script, by its hash.
pub fn script_source(script: &str) -> String {
    format!("'sha256-{}'", BASE64_STANDARD.encode(Sha256::digest(script.as_bytes())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_runs_its_own_script_and_no_other() {
        assert!(!content_policy(None).contains("script-src"));
        // Of the specification of Content Security Policy.
        let policy = content_policy(Some("alert('Hello, world.');"));
        assert!(policy.ends_with("; script-src 'sha256-qznLcsROx4GACP2dm0UCKCzCG+HiZ1guq6ZZDob/Tng='"), "{policy}");
    }
}
