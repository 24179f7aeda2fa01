//! The site's authority (X.509, by rcgen): makes certificates for keys.

use contract::network::{Identity, Name, Party};
use rcgen::{
    BasicConstraints, CertificateParams, CertificateSigningRequestParams, DistinguishedName,
    DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair, KeyUsagePurpose, PublicKeyData,
    date_time_ymd,
};
use time::{Duration, OffsetDateTime};

/// How long the authority itself holds, days.
const OWN_DAYS: i64 = 3650;

/// A key that signs, and its certificate.
pub(super) struct Authority {
    issuer: Issuer<'static, KeyPair>,
    certificate: String,
}

impl Authority {
    /// A new one, for a site.
    pub(super) fn make(site: &str) -> Result<Self, String> {
        let key = KeyPair::generate().map_err(text)?;
        let mut own = params(&format!("authority of {site}"), Duration::days(OWN_DAYS))?;
        own.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
        own.key_usages = vec![KeyUsagePurpose::KeyCertSign];
        let certificate = own.self_signed(&key).map_err(text)?.pem();
        Ok(Self {
            issuer: Issuer::new(own, key),
            certificate,
        })
    }

    /// One that was made before.
    pub(super) fn load(key: &str, certificate: String) -> Result<Self, String> {
        let key = KeyPair::from_pem(key).map_err(|error| format!("its key: {error}"))?;
        let issuer = Issuer::from_ca_cert_pem(&certificate, key)
            .map_err(|error| format!("its certificate: {error}"))?;
        Ok(Self {
            issuer,
            certificate,
        })
    }

    pub(super) fn certificate(&self) -> &str {
        &self.certificate
    }

    /// The secret, to be stored.
    pub(super) fn key(&self) -> String {
        self.issuer.key().serialize_pem()
    }

    /// An identity with a new key.
    pub(super) fn identity(&self, name: &Name, days: f64) -> Result<Identity, String> {
        let key = KeyPair::generate().map_err(text)?;
        let certificate = self.certify(name, &key, days)?;
        Identity::new(key.serialize_pem(), certificate, self.certificate.clone())
    }

    /// A certificate for the key of a request (PKCS #10, PEM). Nothing else in it counts.
    pub(super) fn sign(&self, name: &Name, request: &str, days: f64) -> Result<String, String> {
        let request = CertificateSigningRequestParams::from_pem(request)
            .map_err(|error| format!("no request for a certificate: {error}"))?;
        self.certify(name, &request.public_key, days)
    }

    fn certify(&self, name: &Name, key: &impl PublicKeyData, days: f64) -> Result<String, String> {
        let mut leaf = params(&name.to_string(), Duration::seconds_f64(days * 86_400.0))?;
        leaf.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        leaf.use_authority_key_identifier_extension = true;
        // Only the mediator's lets itself be connected to: nobody else can pass for it.
        leaf.extended_key_usages = match name.party {
            Party::Mediator => vec![
                ExtendedKeyUsagePurpose::ServerAuth,
                ExtendedKeyUsagePurpose::ClientAuth,
            ],
            Party::Robot(_) | Party::Operator(_) => vec![ExtendedKeyUsagePurpose::ClientAuth],
        };
        let certificate = leaf.signed_by(key, &self.issuer).map_err(text)?;
        Ok(certificate.pem())
    }
}

/// Of a certificate that holds from long ago: a robot's computer without a battery starts with a clock of the past.
fn params(common_name: &str, holds: Duration) -> Result<CertificateParams, String> {
    let mut params = CertificateParams::default();
    params.distinguished_name = DistinguishedName::new();
    params
        .distinguished_name
        .push(DnType::CommonName, common_name);
    params.not_before = date_time_ymd(1970, 1, 1);
    params.not_after = OffsetDateTime::now_utc()
        .checked_add(holds)
        .ok_or("this computer's clock is beyond all dates")?;
    Ok(params)
}

fn text(error: rcgen::Error) -> String {
    error.to_string()
}
