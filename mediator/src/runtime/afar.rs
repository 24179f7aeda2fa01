//! Asks a mediator over the fleet's network, as an operator with a certificate.

use std::time::Duration;

use contract::keys;
use contract::network::{Access, Identity, NetworkSettings, Party, Security};
use zenoh::Wait;

use super::question::{Answer, Question};

/// Timeout of an answer.
const PATIENCE: Duration = Duration::from_secs(5);

/// Asks the mediator that listens at an endpoint.
///
/// # Errors
/// A sentence that says why there is no answer.
pub fn ask_from_afar(
    endpoint: &str,
    key_prefix: &str,
    identity: Identity,
    question: &Question,
) -> Result<Answer, String> {
    let operator = match &identity.name().party {
        Party::Operator(name) => name.clone(),
        _ => {
            return Err(format!(
                "the certificate is of {}, expected an operator's: make one with `mediator keys operator NAME`",
                identity.name()
            ));
        }
    };
    let settings = NetworkSettings {
        connect: vec![endpoint.to_owned()],
        security: Some(Security {
            identity,
            access: Access::MediatorOnly,
        }),
        client: true,
        ..NetworkSettings::default()
    };
    settings.check().map_err(|error| error.to_string())?;
    let none = |why: String| format!("no mediator answers at {endpoint}: {why}");
    let session = settings.open().map_err(none)?;
    let key = keys::question(key_prefix, &operator).map_err(|error| error.to_string())?;
    let line = serde_json::to_string(question).expect("a question is always JSON");
    let replies = { session.get(key).payload(line).timeout(PATIENCE).wait() }
        .map_err(|error| none(error.to_string()))?;
    let refused = "nothing within 5 s; is the certificate revoked, is --key-prefix the mediator's?";
    let reply = replies.recv().map_err(|_| none(refused.to_owned()))?;
    let sample = reply.into_result().map_err(|_| none(refused.to_owned()))?;
    let text = sample.payload().to_bytes();
    serde_json::from_slice(&text)
        .map_err(|_| format!("unexpected answer: {}", String::from_utf8_lossy(&text)))
}
