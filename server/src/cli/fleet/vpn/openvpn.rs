//! OpenVPN: an authority with the server's certificate, a certificate for each vessel, and files in `DATA/vpn/openvpn`.
//!
//! `openvpn.key` in the fleet's folder is the authority with the server's part. `NAME.ovpn` is a vessel's: its address, the name
//! in its certificate, then certificate, key and the authority's certificate. The name in a certificate is `NAME.SERIAL`, and
//! OpenVPN lets in only those that have a file of that name in `lutra.ccd`. So the present certificate of a vessel is good and no
//! other, as by WireGuard the present key: what was replaced, taken, or made by a server that was lost since is refused without a
//! list of it.

use super::super::files::{self, Became, Files};
use super::super::state;
use super::certificates::{self, Purpose, Serial};
use super::{Member, Tunnel};
use crate::tls::DAY_US;
use anyhow::Context as _;
use provision::openvpn::{self, Aboard, Shore};
use provision::{Fleet, INTERFACE, Part, Vessel, authority_validity};
use shore::clock;
use std::collections::BTreeSet;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use units::UtcTime;

/// What vessels' files in the fleet's folder end with.
const EXTENSION: &str = "ovpn";
/// A person is told of the authority's end this long before: boats must all be visited (µs).
const NOTICE_US: i64 = 365 * DAY_US;
/// The digits of a serial number in the name of a certificate.
const SERIAL_DIGITS: usize = 2 * size_of::<Serial>();

pub(super) struct OpenVpn<'a>(pub(super) &'a Files);

/// A vessel's certificate and its address.
struct Access {
    address: Ipv4Addr,
    /// The name in the certificate.
    common_name: String,
    aboard: Aboard,
}

/// What a vessel's file holds.
enum Kept {
    Access(Access),
    /// A certificate with the vessel's name alone in it, which an earlier version made. OpenVPN refuses it.
    Earlier,
}

impl OpenVpn<'_> {
    fn shore(&self) -> anyhow::Result<Option<Shore>> {
        let path = self.shore_path();
        let Some(text) = files::read(&path)? else { return Ok(None) };
        Shore::parse(&text).map(Some).with_context(|| self.0.server_key_is(Became::Damaged, &path))
    }

    fn own_shore(&self) -> anyhow::Result<Shore> {
        self.shore()?.with_context(|| self.0.server_key_is(Became::Lost, &self.shore_path()))
    }

    /// What a vessel's file says, whichever authority signed its certificate.
    fn kept(&self, name: &str) -> anyhow::Result<Option<Kept>> {
        let path = self.path(name);
        let Some(text) = files::read(&path)? else { return Ok(None) };
        let read = || {
            let mut lines = text.lines();
            let address = lines.next()?.trim().parse().ok()?;
            let (second, aboard) = (lines.next()?.trim(), Aboard::parse(&text)?);
            if owner(second) == Some(name) {
                return Some(Kept::Access(Access { address, common_name: second.to_owned(), aboard }));
            }
            is_hex(second, 32).then_some(Kept::Earlier)
        };
        read().map(Some).with_context(|| files::unusable(&path, Became::Damaged))
    }

    /// A vessel's certificate, if it is good.
    fn access(&self, name: &str) -> anyhow::Result<Option<Access>> {
        let (Some(shore), Some(Kept::Access(access))) = (self.shore()?, self.kept(name)?) else {
            return Ok(None);
        };
        Ok(Some(access).filter(|access| is_signed_by(&shore, access)))
    }

    fn places_folder(&self) -> PathBuf {
        self.folder().join(openvpn::PLACES)
    }

    /// A vessel's files in the folder that OpenVPN looks into.
    fn places_of(&self, name: &str) -> anyhow::Result<Vec<PathBuf>> {
        let mut places = files::entries(&self.places_folder())?;
        places.retain(|path| belongs_to(path, name));
        Ok(places)
    }

    /// Removes them. Returns whether there was one.
    fn end_places(&self, name: &str) -> anyhow::Result<bool> {
        files::remove_all(&self.places_of(name)?)
    }
}

fn is_signed_by(shore: &Shore, access: &Access) -> bool {
    access.aboard.authority.trim() == shore.authority.certificate.trim()
}

/// A new certificate of a vessel.
fn sign(shore: Shore, name: &str, now: UtcTime) -> anyhow::Result<(String, Aboard)> {
    let serial: Serial = state::random()?;
    let common_name = format!("{name}.{}", hex::encode(serial));
    let identity = certificates::sign(&shore.authority, &common_name, Purpose::Vessel, serial, now)?;
    Ok((common_name, Aboard { identity, authority: shore.authority.certificate }))
}

/// The vessel of a certificate, by the name in it.
fn owner(common_name: &str) -> Option<&str> {
    common_name.rsplit_once('.').filter(|(_, serial)| is_hex(serial, SERIAL_DIGITS)).map(|(name, _)| name)
}

fn belongs_to(place: &Path, name: &str) -> bool {
    place.file_name().and_then(|file| owner(file.to_str()?)) == Some(name)
}

fn is_hex(text: &str, digits: usize) -> bool {
    text.len() == digits && text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

impl Tunnel for OpenVpn<'_> {
    fn has_shore(&self) -> anyhow::Result<bool> {
        Ok(self.shore()?.is_some())
    }

    fn shore_path(&self) -> PathBuf {
        self.0.secret("openvpn.key")
    }

    fn make_shore(&self, now: UtcTime) -> anyhow::Result<()> {
        clock::check(now)
            .map_err(|why| anyhow::anyhow!("no certificate is made: {why}, then do this again"))?;
        let authority = certificates::authority(now)?;
        let serial = state::random()?;
        let server = certificates::sign(&authority, openvpn::SERVER, Purpose::Server, serial, now)?;
        let shore = Shore { authority, server, shield: openvpn::static_key(&state::random()?) };
        files::write(&self.shore_path(), shore.written().as_bytes())
    }

    fn address(&self, name: &str) -> anyhow::Result<Option<Ipv4Addr>> {
        Ok(self.access(name)?.map(|access| access.address))
    }

    fn give(&self, name: &str, address: Ipv4Addr, new: bool, now: UtcTime) -> anyhow::Result<()> {
        let shore = self.own_shore()?;
        let present = if new { None } else { self.access(name)? };
        let (common_name, aboard) = match present {
            Some(access) => (access.common_name, access.aboard),
            None => sign(shore, name, now)?,
        };
        let text = format!("{address}\n{common_name}\n{}", aboard.written());
        files::write(&self.path(name), text.as_bytes())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.secret(&format!("{name}.{EXTENSION}"))
    }

    fn standing(&self, name: &str) -> anyhow::Result<Option<Ipv4Addr>> {
        if matches!(self.kept(name), Ok(Some(_))) {
            return Ok(None);
        }
        let Some(place) = self.places_of(name)?.into_iter().next() else { return Ok(None) };
        let text = files::read(&place)?.unwrap_or_default();
        openvpn::placed(&text).map(Some).with_context(|| format!("{} is damaged too", place.display()))
    }

    fn names(&self) -> anyhow::Result<Vec<String>> {
        let places = files::entries(&self.places_folder())?;
        let placed = places.iter().filter_map(|path| owner(path.file_name()?.to_str()?).map(str::to_owned));
        Ok(self.0.names(EXTENSION)?.into_iter().chain(placed).collect::<BTreeSet<_>>().into_iter().collect())
    }

    fn forget(&self, name: &str) -> anyhow::Result<bool> {
        // Its place first: by that it comes in. Each goes though the other cannot.
        let place = self.end_places(name);
        let kept = files::remove(&self.path(name))?;
        Ok(place? || kept)
    }

    fn places(&self) -> Option<PathBuf> {
        Some(self.places_folder())
    }

    fn folder(&self) -> PathBuf {
        self.0.vpn().join("openvpn")
    }

    fn written(&self) -> Vec<PathBuf> {
        vec![self.folder()]
    }

    fn texts(&self, fleet: &Fleet, members: &[Member]) -> anyhow::Result<Vec<(PathBuf, String)>> {
        let shore = self.own_shore()?;
        let mut texts =
            vec![(self.folder().join(format!("{INTERFACE}.conf")), openvpn::ashore(fleet, &shore))];
        for Member { name, address } in members {
            let places = match self.kept(name) {
                Ok(Some(Kept::Access(access))) => vec![self.places_folder().join(access.common_name)],
                Ok(Some(Kept::Earlier)) => Vec::new(),
                // Damaged or lost: the place that it has stays.
                Ok(None) | Err(_) => self.places_of(name)?,
            };
            let place = openvpn::place(fleet.vpn.network, *address);
            texts.extend(places.into_iter().map(|path| (path, place.clone())));
        }
        Ok(texts)
    }

    fn aboard(&self, fleet: &Fleet, vessel: &Vessel) -> anyhow::Result<(Part, String)> {
        let access = self.access(&vessel.name)?.with_context(|| state::no_key(&vessel.name))?;
        let shore = self.own_shore()?;
        Ok((Part::OpenVpn, openvpn::aboard(fleet, vessel, &access.aboard, &shore.shield)))
    }

    fn doubts(&self, now: UtcTime) -> anyhow::Result<Vec<String>> {
        let Some(shore) = self.shore()? else { return Ok(Vec::new()) };
        let mut doubts = Vec::new();
        for name in self.names()? {
            let by = match self.kept(&name) {
                Ok(Some(Kept::Earlier)) => "an earlier version made",
                Ok(Some(Kept::Access(access))) if !is_signed_by(&shore, &access) => {
                    "an authority before this one signed"
                }
                Ok(Some(Kept::Access(_)) | None) | Err(_) => continue,
            };
            doubts.push(format!(
                "{by} the certificate of {name}, and OpenVPN refuses it once root has the new files: `lutra-server fleet apply` makes \
                 another where the vessel is in the fleet file; the boat needs a new bundle"
            ));
        }
        let until = authority_validity(&shore.authority.certificate).map(|validity| validity.until);
        let near = until.filter(|until| *until - now < NOTICE_US);
        doubts.extend(near.map(|until| {
            format!(
                "the certificates of the VPN end on {}: before that remove {}, apply the fleet file with --new-server-key and bring \
                 every boat a new bundle",
                clock::written(until),
                self.shore_path().display()
            )
        }));
        Ok(doubts)
    }

    fn steps(&self) -> Vec<String> {
        let there = "/etc/openvpn/server";
        vec![
            // Also takes out boats that have no place any more.
            format!("sudo rm -rf {there}/{}", openvpn::PLACES),
            format!("sudo cp -r {}/. {there}/", self.folder().display()),
            format!("sudo chmod -R a+rX {there}/{}", openvpn::PLACES),
            "sudo systemctl enable openvpn-server@lutra".to_owned(),
            "sudo systemctl restart openvpn-server@lutra".to_owned(),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const ADDRESS: Ipv4Addr = Ipv4Addr::new(10, 8, 0, 11);

    fn now() -> UtcTime {
        clock::now()
    }

    #[test]
    fn a_new_certificate_has_a_name_of_its_own_and_one_of_another_authority_is_not_good() {
        let data = tempfile::tempdir().unwrap();
        let files = Files::new(data.path(), None);
        let vpn = OpenVpn(&files);
        assert!(!vpn.has_shore().unwrap() && vpn.address("otter-01").unwrap().is_none());
        vpn.make_shore(now()).unwrap();
        vpn.give("otter-01", ADDRESS, true, now()).unwrap();
        let named = || vpn.access("otter-01").unwrap().unwrap().common_name;
        let first = named();
        assert_eq!(owner(&first), Some("otter-01"));
        vpn.give("otter-01", [10, 8, 0, 12].into(), false, now()).unwrap();
        assert_eq!(named(), first, "it moves with its certificate");
        vpn.give("otter-01", ADDRESS, true, now()).unwrap();
        assert_ne!(named(), first);
        assert!(vpn.forget("otter-01").unwrap() && !vpn.forget("otter-01").unwrap());

        vpn.give("otter-01", ADDRESS, true, now()).unwrap();
        fs::remove_file(vpn.shore_path()).unwrap();
        assert_eq!(vpn.address("otter-01").unwrap(), None);
        vpn.make_shore(now()).unwrap();
        assert_eq!(vpn.address("otter-01").unwrap(), None, "another authority signed it");
        fs::write(vpn.path("otter-01"), "half").unwrap();
        let why = vpn.address("otter-01").err().unwrap().to_string();
        assert!(
            why.contains("otter-01.ovpn is damaged: bring it back from the backup; without one remove it"),
            "{why}"
        );
    }

    #[test]
    fn a_vessel_loses_its_place_whatever_became_of_its_file_and_no_other_vessel_does() {
        let data = tempfile::tempdir().unwrap();
        let files = Files::new(data.path(), None);
        let vpn = OpenVpn(&files);
        // The name of one begins as that of a certificate of the other.
        let names = ["otter", "otter.0123456789abcdef"];
        for name in names {
            fs::create_dir_all(vpn.places_folder()).unwrap();
            fs::write(vpn.places_folder().join(format!("{name}.00000000000000ff")), "").unwrap();
        }
        files::write(&vpn.path("otter"), b"half").unwrap();
        assert!(vpn.forget("otter").unwrap(), "the server's key is not asked for");
        assert_eq!(vpn.names().unwrap(), names[1..], "by its place alone");
        assert!(vpn.places_of(names[0]).unwrap().is_empty());
        assert_eq!(vpn.places_of(names[1]).unwrap().len(), 1);
    }

    #[test]
    fn a_certificate_of_an_earlier_version_is_named_and_not_good() {
        let data = tempfile::tempdir().unwrap();
        let files = Files::new(data.path(), None);
        let vpn = OpenVpn(&files);
        vpn.make_shore(now()).unwrap();
        vpn.give("otter-01", ADDRESS, true, now()).unwrap();
        let text = fs::read_to_string(vpn.path("otter-01")).unwrap();
        let named = vpn.access("otter-01").unwrap().unwrap().common_name;
        fs::write(vpn.path("otter-01"), text.replace(&named, &"0a".repeat(16))).unwrap();
        assert_eq!(vpn.address("otter-01").unwrap(), None);
        let told = vpn.doubts(now()).unwrap().concat();
        assert!(told.contains("of otter-01,") && told.contains("needs a new bundle"), "{told}");
    }

    #[test]
    fn the_end_of_the_authority_is_told_a_year_before() {
        let data = tempfile::tempdir().unwrap();
        let files = Files::new(data.path(), None);
        let vpn = OpenVpn(&files);
        vpn.make_shore(now()).unwrap();
        let in_days = |days: i64| UtcTime::from_micros(now().micros() + days * DAY_US);
        assert!(vpn.doubts(now()).unwrap().is_empty() && vpn.doubts(in_days(3_200)).unwrap().is_empty());
        let told = vpn.doubts(in_days(3_400)).unwrap().concat();
        assert!(told.contains("end on") && told.contains("openvpn.key"), "{told}");
        let why = vpn.give("otter-01", ADDRESS, true, in_days(3_700)).unwrap_err().to_string();
        assert!(why.contains("authority ended on"), "{why}");
        let why = vpn.make_shore(UtcTime::from_micros(1)).unwrap_err().to_string();
        assert!(why.contains("no certificate is made"), "{why}");
    }
}
