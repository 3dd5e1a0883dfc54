//! Suggestions for misspelt words.

/// Longer words are not compared.
const MAX_COMPARED: usize = 255;

/// Of more words than these the first are compared.
const MAX_KNOWN: usize = 10_000;

/// A question for the most similar of `known`, if one is similar.
pub fn did_you_mean<S: AsRef<str>>(found: &str, known: &[S]) -> Option<String> {
    nearest(found, known).map(|best| format!("did you mean `{}`?", best.as_ref()))
}

/// The most similar of `known`, if one is similar.
pub fn nearest<'k, S: AsRef<str>>(found: &str, known: &'k [S]) -> Option<&'k S> {
    // A word that long is no slip of another, and comparing it would take long.
    if found.len() > MAX_COMPARED {
        return None;
    }
    let known = &known[..known.len().min(MAX_KNOWN)];
    let similarity = |name: &S| strsim::jaro_winkler(&found.to_lowercase(), &name.as_ref().to_lowercase());
    let best = known.iter().max_by(|a, b| similarity(a).total_cmp(&similarity(b)))?;
    (similarity(best) >= 0.8).then_some(best)
}
