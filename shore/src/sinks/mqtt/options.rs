//! How a broker is reached, of what is configured.

use crate::sinks::{secret, settings};
use crate::tls::trusting;
use anyhow::{Context as _, bail, ensure};
use hyper::Uri;
use rumqttc::v5::MqttOptions;
use rumqttc::{TlsConfiguration, Transport};
use std::time::Duration;

/// How often a connection on which nothing else goes is tried.
const KEEP_ALIVE: Duration = Duration::from_secs(15);
/// How long a broker may take to let us in.
const CONNECT_S: u64 = 10;
/// Messages that wait for their confirmation at once; a broker may want fewer.
const IN_FLIGHT: u16 = 256;
/// The largest value of a broker's that is read.
const LARGEST_HELD_BYTES: u32 = 1 << 20;

/// What rumqttc is given.
///
/// # Errors
/// What is configured cannot be used; the error names the key and shows no secret.
pub(super) fn options(settings: &settings::Mqtt) -> anyhow::Result<MqttOptions> {
    let url = &settings.url;
    // No error shows the address: a password may stand in it, also where it does not look like one.
    ensure!(
        !url.contains(['@', '#']) && !url.contains(char::is_whitespace),
        "sinks.mqtt.url must be like mqtt://host:1883, without @, # and spaces; user and password are named by sinks.mqtt.user and \
         password_file"
    );
    let uri: Uri =
        url.parse().context("sinks.mqtt.url is not an address; it must be like mqtt://host:1883")?;
    let host = uri.host().context("sinks.mqtt.url names no host; it must be like mqtt://host:1883")?;
    let has_port = uri.authority().is_some_and(|authority| authority.as_str().len() > host.len());
    ensure!(
        !has_port || uri.port_u16().is_some_and(|port| port > 0),
        "sinks.mqtt.url: the port behind the host must be a number from 1 to 65535"
    );
    ensure!(
        matches!(uri.path(), "" | "/") && uri.query().is_none(),
        "sinks.mqtt.url must end behind host and port; topics are named by sinks.mqtt.topic"
    );
    let tls = match uri.scheme_str() {
        Some("mqtt") => None,
        Some("mqtts") => {
            ensure!(
                !settings.ca_file.as_os_str().is_empty(),
                "sinks.mqtt.url is mqtts: name the authority that signed its certificate by sinks.mqtt.ca_file"
            );
            ensure!(
                !host.starts_with('['),
                "sinks.mqtt.url is encrypted and names an address of IPv6: name the host as its certificate does"
            );
            Some(trusting("sinks.mqtt.ca_file", &settings.ca_file)?)
        }
        _ => bail!("sinks.mqtt.url must begin with mqtt:// or mqtts://"),
    };
    let port = uri.port_u16().unwrap_or(if tls.is_some() { 8883 } else { 1883 });
    let mut options = MqttOptions::new(settings.client_id.clone(), host, port);
    options.set_keep_alive(KEEP_ALIVE).set_clean_start(true).set_connection_timeout(CONNECT_S);
    options.set_outgoing_inflight_upper_limit(IN_FLIGHT);
    options.set_max_packet_size(Some(LARGEST_HELD_BYTES));
    if let Some(tls) = tls {
        options.set_transport(Transport::Tls(TlsConfiguration::Rustls(tls.config().clone())));
    }
    if !settings.user.is_empty() {
        let password = secret("sinks.mqtt.password_file", &settings.password_file)?;
        options.set_credentials(settings.user.clone(), password);
    }
    Ok(options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_that_cannot_be_used_are_said_with_their_key() {
        let made = |url: &str, ca: &str| {
            let (url, ca_file) = (url.to_owned(), ca.into());
            options(&settings::Mqtt { url, ca_file, ..settings::Mqtt::default() })
        };
        for (url, port) in [("mqtt://broker", 1883), ("mqtt://[::1]:99/", 99)] {
            assert_eq!(made(url, "").unwrap().broker_address().1, port);
        }
        for (url, ca, why) in [
            ("http://there", "", "must begin with mqtt://"),
            ("mqtt://", "", "sinks.mqtt.url"),
            ("mqtt://me:hush@there", "", "without @"),
            ("mqtt://me:hu#sh@there", "", "without @"),
            ("mqtt://me:hu/sh@there", "", "without @"),
            ("mqtt://there#hush", "", "without @"),
            ("mqtt://me:hush there", "", "without @"),
            ("mqtt://there:hush", "", "sinks.mqtt.url"),
            ("mqtt://there:99999", "", "from 1 to 65535"),
            ("mqtt://there:0", "", "from 1 to 65535"),
            ("mqtt://there:", "", "from 1 to 65535"),
            ("mqtt://there/hush?hush", "", "must end behind"),
            ("mqtt://there/lutra", "", "must end behind host and port"),
            ("mqtts://there", "", "sinks.mqtt.ca_file"),
            ("mqtts://there", "/none", "sinks.mqtt.ca_file /none"),
            ("mqtts://[::1]", "/none", "as its certificate does"),
        ] {
            let error = made(url, ca).err().map(|error| format!("{error:#}")).unwrap_or_default();
            assert!(error.contains(why), "{url}: {error}");
            assert!(!error.contains("hu"), "{url}: a password may be in it: {error}");
        }
    }
}
