//! Lines for notebooks that fetch exactly one version, and say where the archive gives other bytes than were published.

use api::{DatasetContent, DatasetVersion};

/// How a script shows that it may have the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// By a token, from the environment.
    Token,
    /// By the address alone.
    Address,
    /// By the address and a password, from the environment.
    Password,
}

impl Access {
    /// Header, the text before the secret, and the variable with the secret.
    const fn header(self) -> Option<(&'static str, &'static str, &'static str)> {
        match self {
            Self::Token => Some(("Authorization", "Bearer ", "LUTRA_TOKEN")),
            Self::Address => None,
            Self::Password => Some(("Lutra-Link-Password", "", "LUTRA_LINK_PASSWORD")),
        }
    }
}

fn about(version: &DatasetVersion, content: &DatasetContent) -> String {
    let title: String = version.title.chars().filter(|letter| !letter.is_control()).collect();
    format!("# {title}, version {}: {} detections\n", version.number, content.rows)
}

/// The remark on other bytes. Those of a part are compared with the making of its link.
fn other_bytes(version: &DatasetVersion, content: &DatasetContent) -> &'static str {
    if content.sha256 == version.content.sha256 {
        "These are not the bytes that were published: the archive has changed since, or another version of Lutra writes them."
    } else {
        "These are not the bytes that the link gave at first: the archive has changed since this link was made, or another version \
         of Lutra writes them."
    }
}

/// For Python with pandas.
pub fn python(version: &DatasetVersion, content: &DatasetContent, file: &str, access: Access) -> String {
    let (imports, headers) = match access.header() {
        Some((name, before, variable)) => {
            let secret = format!("os.environ[\"{variable}\"]");
            let value = if before.is_empty() { secret } else { format!("\"{before}\" + {secret}") };
            ("hashlib, io, os, urllib.request", format!(", headers={{\"{name}\": {value}}}"))
        }
        None => ("hashlib, io, urllib.request", String::new()),
    };
    format!(
        "{}import {imports}\nimport pandas as pd\n\n\
         request = urllib.request.Request(\"{file}\"{headers})\n\
         data = urllib.request.urlopen(request).read()\n\
         if hashlib.sha256(data).hexdigest() != \"{}\":\n    \
         print(\"{}\")\n\
         detections = pd.read_csv(io.BytesIO(data), parse_dates=[\"heard_utc\", \"reported_utc\", \"received_utc\"])\n",
        about(version, content),
        content.sha256,
        other_bytes(version, content),
    )
}

/// For R; the package digest reckons the hash.
pub fn r(version: &DatasetVersion, content: &DatasetContent, file: &str, access: Access) -> String {
    let headers = access.header().map(|(name, before, variable)| {
        format!(",\n              headers = c(\"{name}\" = paste0(\"{before}\", Sys.getenv(\"{variable}\")))")
    });
    format!(
        "{}file <- tempfile(fileext = \".csv\")\n\
         download.file(\"{file}\", file, mode = \"wb\"{})\n\
         if (digest::digest(file = file, algo = \"sha256\") != \"{}\")\n  \
         warning(\"{}\")\n\
         detections <- read.csv(file, check.names = FALSE)\n",
        about(version, content),
        headers.unwrap_or_default(),
        content.sha256,
        other_bytes(version, content),
    )
}
