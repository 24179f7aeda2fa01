//! Who a party on the fleet's network is: a key, and a certificate of the site's authority with the party's name in it.
//!
//! A file of an identity has three PEM blocks: the key (PKCS #8), its certificate, the authority's certificate. The name is
//! the certificate's common name: `mediator`, `robots/ID/GENERATION` or `operators/NAME/GENERATION`. Revoking makes the next
//! generation, and those before mean nothing.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use description::names::is_key_part;
use rcgen::{CertificateParams, KeyPair, PublicKeyData};
use x509_parser::certificate::X509Certificate;
use x509_parser::pem::Pem;

use crate::private;

/// Upper bound of a common name, bytes (X.520, `ub-common-name`).
pub const LONGEST_NAME: usize = 64;

/// A party.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Party {
    /// Whoever speaks for the site.
    Mediator,
    /// The robot with this id.
    Robot(String),
    /// The operator with this name.
    Operator(String),
}

/// The name in a certificate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    /// Of whom it is.
    pub party: Party,
    /// Counts from 1; the mediator has only one.
    pub generation: u32,
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let generation = self.generation;
        match &self.party {
            Party::Mediator => write!(f, "mediator"),
            Party::Robot(id) => write!(f, "robots/{id}/{generation}"),
            Party::Operator(name) => write!(f, "operators/{name}/{generation}"),
        }
    }
}

impl FromStr for Name {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "expected `mediator`, `robots/ID/GENERATION` or `operators/NAME/GENERATION`, found `{text}`"
            )
        };
        if text == "mediator" {
            return Ok(Self {
                party: Party::Mediator,
                generation: 1,
            });
        }
        let parts: Vec<&str> = text.split('/').collect();
        let [kind, name, generation] = parts[..] else {
            return Err(wrong());
        };
        let generation = generation.parse().map_err(|_| wrong())?;
        if !is_key_part(name) || generation == 0 {
            return Err(wrong());
        }
        let name = name.to_owned();
        let party = match kind {
            "robots" => Party::Robot(name),
            "operators" => Party::Operator(name),
            _ => return Err(wrong()),
        };
        Ok(Self { party, generation })
    }
}

/// A party with all that it needs to show who it is, and to see who others are.
#[derive(Clone, PartialEq, Eq)]
pub struct Identity {
    name: Name,
    expires_unix_s: i64,
    key: String,
    certificate: String,
    authority: String,
}

impl fmt::Debug for Identity {
    // Without its key.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Identity")
            .field("name", &self.name)
            .field("expires_unix_s", &self.expires_unix_s)
            .finish_non_exhaustive()
    }
}

impl Identity {
    /// Puts an identity together from its three blocks.
    ///
    /// # Errors
    /// A sentence: a block is damaged, the key is another one's, or the certificate is not the authority's.
    pub fn new(key: String, certificate: String, authority: String) -> Result<Self, String> {
        let pair = KeyPair::from_pem(&key).map_err(|error| format!("its key: {error}"))?;
        let (leaf, root) = (der(&certificate)?, der(&authority)?);
        let (leaf, root) = (parsed(&leaf)?, parsed(&root)?);
        if leaf.public_key().raw != pair.subject_public_key_info() {
            return Err("its certificate is not of its key".to_owned());
        }
        leaf.verify_signature(Some(root.public_key()))
            .map_err(|_| "its certificate is not of its authority".to_owned())?;
        let name = { leaf.subject().iter_common_name().next() }
            .and_then(|name| name.as_str().ok())
            .ok_or("its certificate has no common name")?;
        Ok(Self {
            name: name.parse().map_err(|error| format!("its name: {error}"))?,
            expires_unix_s: leaf.validity().not_after.timestamp(),
            key,
            certificate,
            authority,
        })
    }

    /// Reads an identity.
    ///
    /// # Errors
    /// A sentence: what the text lacks, or what [`Identity::new`] finds.
    pub fn parse(text: &str) -> Result<Self, String> {
        let blocks = blocks(text);
        let found: Vec<&str> = blocks.iter().map(|(label, _)| *label).collect();
        let [
            ("PRIVATE KEY", key),
            ("CERTIFICATE", own),
            ("CERTIFICATE", root),
        ] = blocks[..]
        else {
            return Err(format!(
                "expected the PEM blocks PRIVATE KEY, CERTIFICATE (its own) and CERTIFICATE (the authority's), found {found:?}"
            ));
        };
        Self::new(key.to_owned(), own.to_owned(), root.to_owned())
    }

    /// Reads the file of an identity, which nobody else can have read or written.
    ///
    /// # Errors
    /// A sentence that names the file.
    pub fn load(path: &Path) -> Result<Self, String> {
        let bytes = private::read(path).map_err(|error| error.to_string())?;
        let text = std::str::from_utf8(&bytes).map_err(|_| "expected PEM blocks".to_owned());
        text.and_then(Self::parse)
            .map_err(|error| format!("{}: {error}", path.display()))
    }

    /// As [`parse`](Self::parse) reads it. It is a secret.
    #[must_use]
    pub fn to_pem(&self) -> String {
        format!("{}{}{}", self.key, self.certificate, self.authority)
    }

    /// Whose it is.
    #[must_use]
    pub fn name(&self) -> &Name {
        &self.name
    }

    /// Until when it is of use, by the clock of whoever looks at it.
    #[must_use]
    pub fn expires_unix_s(&self) -> i64 {
        self.expires_unix_s
    }

    /// A request for the next certificate, with a key of its own.
    ///
    /// # Errors
    /// A sentence: no key can be made.
    pub fn request(&self) -> Result<Request, String> {
        let text = |error: rcgen::Error| error.to_string();
        let key = KeyPair::generate().map_err(text)?;
        let request = CertificateParams::default().serialize_request(&key);
        Ok(Request {
            request: request.and_then(|request| request.pem()).map_err(text)?,
            key: key.serialize_pem(),
            name: self.name.clone(),
            authority: self.authority.clone(),
        })
    }

    pub(super) fn key(&self) -> &str {
        &self.key
    }

    pub(super) fn certificate(&self) -> &str {
        &self.certificate
    }

    pub(super) fn authority(&self) -> &str {
        &self.authority
    }
}

/// A request for the next certificate of an identity. Its key never leaves the party.
pub struct Request {
    request: String,
    key: String,
    name: Name,
    authority: String,
}

impl Request {
    /// What the mediator is sent (PKCS #10, PEM).
    #[must_use]
    pub fn pem(&self) -> &str {
        &self.request
    }

    /// The identity with the certificate that was asked for.
    ///
    /// # Errors
    /// A sentence: it is not for this request, or not by the same authority.
    pub fn answered(self, certificate: &str) -> Result<Identity, String> {
        let block = match blocks(certificate)[..] {
            [("CERTIFICATE", block)] => block.to_owned(),
            _ => return Err("expected one PEM block CERTIFICATE".to_owned()),
        };
        let identity = Identity::new(self.key, block, self.authority)?;
        if identity.name == self.name {
            Ok(identity)
        } else {
            Err(format!(
                "it is of {}, expected {}",
                identity.name, self.name
            ))
        }
    }
}

/// All PEM blocks with their labels; what stands between them is left out.
fn blocks(text: &str) -> Vec<(&str, &str)> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(begin) = rest.find("-----BEGIN ") {
        rest = &rest[begin..];
        let label = &rest["-----BEGIN ".len()..];
        let Some(label) = label.find("-----").map(|end| &label[..end]) else {
            break;
        };
        let last = format!("-----END {label}-----");
        let Some(end) = rest.find(&last) else { break };
        let mut end = end + last.len();
        end += rest[end..].len() - rest[end..].trim_start_matches(['\r', '\n']).len();
        found.push((label, &rest[..end]));
        rest = &rest[end..];
    }
    found
}

fn der(pem: &str) -> Result<Vec<u8>, String> {
    let block = Pem::iter_from_buffer(pem.as_bytes()).next();
    { block.and_then(Result::ok) }
        .map(|block| block.contents)
        .ok_or_else(|| "a PEM block is damaged".to_owned())
}

fn parsed(der: &[u8]) -> Result<X509Certificate<'_>, String> {
    x509_parser::parse_x509_certificate(der)
        .map(|(_, certificate)| certificate)
        .map_err(|error| format!("a certificate is damaged: {error}"))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for text in ["mediator", "robots/amr-1/1", "operators/anna/4294967295"] {
            assert_eq!(text.parse::<Name>().expect(text).to_string(), text);
        }
        for text in [
            "",
            "mediator/1",
            "robots/amr-1",
            "robots/amr-1/0",
            "robots/a b/1",
            "robots/*/1",
            "robots//1",
            "operators/anna/-1",
            "others/a/1",
            "robots/a/1/2",
        ] {
            assert!(text.parse::<Name>().is_err(), "{text}");
        }
    }

    proptest! {
        #[test]
        fn nothing_that_is_no_identity_is_taken_for_one(text in "(-----BEGIN |-----END |CERTIFICATE|PRIVATE KEY|-----|\n|[a-zA-Z0-9+/=]{0,9}){0,40}") {
            prop_assert!(Identity::parse(&text).is_err());
        }
    }
}
