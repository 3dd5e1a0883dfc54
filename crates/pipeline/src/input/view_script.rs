//! The script of a page's 3D view.

use std::borrow::Cow;

/// The script with which the page of a run shows meshes in 3D; the host brings it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ViewScript {
    /// The script: classic, and complete in itself. `None` if the host was built without it.
    pub text: Option<Cow<'static, str>>,
    /// How a host that was built without it gets it.
    pub hint: String,
}

impl ViewScript {
    /// The script as it stands in a page, where nothing within may end the element around it.
    pub fn inline(&self) -> Option<Cow<'static, str>> {
        let text = self.text.clone()?;
        // In strings, the only places where a script has these, the backslash stands for nothing.
        let ends = ["</script", "</SCRIPT", "<!--"];
        if !ends.iter().any(|end| text.contains(end)) {
            return Some(text);
        }
        Some(text.replace("</script", "<\\/script").replace("</SCRIPT", "<\\/SCRIPT").replace("<!--", "<\\!--").into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_script_does_not_end_its_element() {
        let inline = |text: &'static str| ViewScript { text: Some(text.into()), hint: String::new() }.inline();
        assert_eq!(inline("f('</script><!--')").as_deref(), Some("f('<\\/script><\\!--')"));
        assert_eq!(inline("f(1)").as_deref(), Some("f(1)"));
        assert_eq!(ViewScript::default().inline(), None);
    }
}
