//! What a page may do: run its own script, use its own style sheet, and fetch nothing.

use sha2::{Digest, Sha256};

use files::base64;

/// The content security policy of a page that has this style sheet and this script, each the whole content of its element.
pub fn content_security_policy(style: &str, script: &str) -> String {
    let hash = |text: &str| format!("'sha256-{}'", base64(&Sha256::digest(text.as_bytes())));
    format!(
        "default-src 'none'; style-src {}; script-src {}; base-uri 'none'; form-action 'none'",
        hash(style),
        hash(script)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_digest_is_in_base64() {
        // The digest of nothing, as browsers know it.
        let policy = content_security_policy("", "");
        assert_eq!(
            policy.matches("'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='").count(),
            2,
            "{policy}"
        );
    }
}
