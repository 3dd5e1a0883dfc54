//! Suggestions for misspelt words.

/// A question for the most similar of `known`, if one is similar.
pub fn did_you_mean<S: AsRef<str>>(found: &str, known: &[S]) -> Option<String> {
    nearest(found, known).map(|best| format!("did you mean `{}`?", best.as_ref()))
}

/// The most similar of `known`, if one is similar.
pub fn nearest<'k, S: AsRef<str>>(found: &str, known: &'k [S]) -> Option<&'k S> {
    let similarity = |name: &S| strsim::jaro_winkler(&found.to_lowercase(), &name.as_ref().to_lowercase());
    let best = known.iter().max_by(|a, b| similarity(a).total_cmp(&similarity(b)))?;
    (similarity(best) >= 0.8).then_some(best)
}
