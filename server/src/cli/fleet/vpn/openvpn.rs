//! OpenVPN: an authority with the server's certificate, a certificate for each vessel, and files in `DATA/vpn/openvpn`.
//!
//! `openvpn.key` in the fleet's folder is the authority with the server's part, `openvpn.issued` the list of all certificates
//! that it signed, by which they are revoked ([`super::issued`]), `openvpn.crl` the list of revoked
//! certificates: a comment line for each, then what OpenVPN reads. `NAME.ovpn` is a vessel's: its address, the serial number of its
//! certificate, then certificate, key and the authority's certificate. A vessel's certificate is good if this
//! authority signed it and it is not in the list: so a run that was killed between two files does no harm.

use super::super::files::{self, Files};
use super::super::state;
use super::certificates::{self, Purpose, Revoked, Serial};
use super::issued::{Issued, IssuedList};
use super::{Member, Tunnel};
use crate::cli::say::say;
use anyhow::{Context as _, ensure};
use provision::openvpn::{self, Aboard, Identity, Shore};
use provision::{Fleet, INTERFACE, Part, Vessel, authority_validity};
use shore::clock;
use std::fmt::Write as _;
use std::net::Ipv4Addr;
use std::path::PathBuf;
use units::UtcTime;

/// What vessels' files in the fleet's folder end with.
const EXTENSION: &str = "ovpn";
/// A person is told of the authority's end this long before: boats must all be visited (µs).
const NOTICE_US: i64 = 365 * 86_400_000_000;

pub(super) struct OpenVpn<'a>(pub(super) &'a Files);

/// A vessel's certificate and its address.
struct Access {
    address: Ipv4Addr,
    serial: Serial,
    aboard: Aboard,
}

impl OpenVpn<'_> {
    fn shore_path(&self) -> PathBuf {
        self.0.secret("openvpn.key")
    }

    fn revoked_path(&self) -> PathBuf {
        self.0.secret("openvpn.crl")
    }

    fn issued_path(&self) -> PathBuf {
        self.0.secret("openvpn.issued")
    }

    fn shore(&self) -> anyhow::Result<Option<Shore>> {
        let path = self.shore_path();
        let Some(text) = files::read(&path)? else { return Ok(None) };
        Shore::parse(&text).map(Some).with_context(|| {
            format!(
                "{} is damaged: bring it back from a backup; without one remove it, and `lutra-server fleet apply` makes a new \
                 authority: every boat then needs a new bundle",
                path.display()
            )
        })
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.secret(&format!("{name}.{EXTENSION}"))
    }

    /// What a vessel's file says, whether its certificate is good or not.
    fn kept(&self, name: &str) -> anyhow::Result<Option<Access>> {
        let path = self.path(name);
        let Some(text) = files::read(&path)? else { return Ok(None) };
        let mut lines = text.lines();
        let address = lines.next().and_then(|line| line.trim().parse().ok());
        let serial = lines.next().and_then(Serial::parse);
        let access = address.zip(serial).zip(Aboard::parse(&text));
        let access = access.map(|((address, serial), aboard)| Access { address, serial, aboard });
        access.map(Some).with_context(|| files::damaged(&path))
    }

    /// A vessel's certificate, if it is good.
    fn access(&self, name: &str) -> anyhow::Result<Option<Access>> {
        let (Some(shore), Some(access)) = (self.shore()?, self.kept(name)?) else { return Ok(None) };
        let is_ours = access.aboard.authority.trim() == shore.authority.certificate.trim();
        let revoked = self.revoked()?;
        Ok(Some(access).filter(|one| is_ours && revoked.iter().all(|other| other.serial != one.serial)))
    }

    /// The list of revoked certificates, and its text.
    fn list(&self) -> anyhow::Result<(Vec<Revoked>, String)> {
        let path = self.revoked_path();
        let text = files::read(&path)?.filter(|text| text.trim_end().ends_with("-----END X509 CRL-----"));
        let revoked = text.as_ref().and_then(|text| {
            text.lines().filter_map(|line| line.strip_prefix("# ")).map(Revoked::parse).collect()
        });
        revoked.zip(text).with_context(|| {
            format!(
                "{} is damaged or not there, and without it certificates that were revoked would be good again: bring it back \
                 from a backup; without one remove {}, and `lutra-server fleet apply` makes a new authority: every boat then \
                 needs a new bundle",
                path.display(),
                self.shore_path().display()
            )
        })
    }

    fn revoked(&self) -> anyhow::Result<Vec<Revoked>> {
        Ok(self.list()?.0)
    }

    /// Writes the list, signed.
    fn keep_revoked(&self, shore: &Shore, revoked: &[Revoked], now: UtcTime) -> anyhow::Result<()> {
        let mut text = String::new();
        for one in revoked {
            writeln!(text, "# {one}").ok();
        }
        text.push_str(&certificates::list(&shore.authority, revoked, now)?);
        files::write(&self.revoked_path(), text.as_bytes())
    }

    /// Signs a certificate, which is in the list of issued ones before it exists.
    fn sign(
        &self,
        authority: &Identity,
        name: &str,
        purpose: Purpose,
        now: UtcTime,
    ) -> anyhow::Result<(Serial, Identity)> {
        let serial = Serial(state::random()?);
        let issued = Issued { serial, at: now, purpose, name: name.to_owned() };
        IssuedList::add(&self.issued_path(), &issued)?;
        Ok((serial, certificates::sign(authority, name, purpose, serial, now)?))
    }

    /// Adds the certificates in vessels' files to the list of issued ones: earlier versions kept no such list.
    fn enlist(&self, now: UtcTime) -> anyhow::Result<IssuedList> {
        let path = self.issued_path();
        let list = IssuedList::read(&path)?;
        for name in self.0.names(EXTENSION)? {
            // One that is damaged is reported where that vessel is revoked.
            let Ok(Some(Access { serial, .. })) = self.kept(&name) else { continue };
            if !list.has(serial) {
                IssuedList::add(&path, &Issued { serial, at: now, purpose: Purpose::Vessel, name })?;
            }
        }
        IssuedList::read(&path)
    }

    /// Revokes all certificates that a vessel ever got. Returns whether one of them was still good.
    ///
    /// # Errors
    /// Not all of them are known, after those that are were revoked; or a file cannot be read or written.
    fn revoke(&self, name: &str, now: UtcTime) -> anyhow::Result<bool> {
        let Some(shore) = self.shore()? else { return Ok(false) };
        let issued = self.enlist(now)?;
        let mut revoked = self.revoked()?;
        let before = revoked.len();
        let own: Vec<&Issued> = issued.of_vessels().filter(|one| one.name == name).collect();
        for Issued { serial, name, .. } in &own {
            if revoked.iter().all(|other| other.serial != *serial) {
                revoked.push(Revoked { serial: *serial, at: now, name: name.clone() });
            }
        }
        let changed = revoked.len() > before;
        if changed {
            self.keep_revoked(&shore, &revoked, now)?;
        }
        issued.check(&self.issued_path())?;
        ensure!(
            !own.is_empty() || self.kept(name).is_ok(),
            "{} is damaged, and an earlier version made its certificate, which is in no list: bring the file back from a backup; without one remove {}, and `lutra-server fleet apply` makes a new authority: every boat then needs a new bundle",
            self.path(name).display(),
            self.shore_path().display()
        );
        Ok(changed)
    }
}

impl Tunnel for OpenVpn<'_> {
    fn has_shore(&self) -> anyhow::Result<bool> {
        Ok(self.shore()?.is_some())
    }

    fn make_shore(&self, now: UtcTime) -> anyhow::Result<()> {
        clock::check(now)
            .map_err(|why| anyhow::anyhow!("no certificate is made: {why}, then do this again"))?;
        let authority = certificates::authority(now)?;
        // Certificates of an earlier authority count as revoked.
        let earlier = self.enlist(now)?;
        let earlier = earlier.of_vessels();
        let revoked: Vec<Revoked> =
            earlier.map(|one| Revoked { serial: one.serial, at: now, name: one.name.clone() }).collect();
        let (_, server) = self.sign(&authority, openvpn::SERVER, Purpose::Server, now)?;
        let shore = Shore { authority, server, shield: openvpn::static_key(&state::random()?) };
        // The list of revoked ones comes first: a server without it would not start.
        self.keep_revoked(&shore, &revoked, now)?;
        files::write(&self.shore_path(), shore.written().as_bytes())
    }

    fn address(&self, name: &str) -> anyhow::Result<Option<Ipv4Addr>> {
        Ok(self.access(name)?.map(|access| access.address))
    }

    fn give(&self, name: &str, address: Ipv4Addr, new: bool, now: UtcTime) -> anyhow::Result<()> {
        let shore = self.shore()?.with_context(|| state::no_key("the server"))?;
        let present = if new { None } else { self.access(name)? };
        let (serial, aboard) = if let Some(access) = present {
            (access.serial, access.aboard)
        } else {
            self.revoke(name, now)?;
            let (serial, identity) = self.sign(&shore.authority, name, Purpose::Vessel, now)?;
            (serial, Aboard { identity, authority: shore.authority.certificate })
        };
        let text = format!("{address}\n{serial}\n{}", aboard.written());
        files::write(&self.path(name), text.as_bytes())
    }

    fn names(&self) -> anyhow::Result<Vec<String>> {
        let mut names = self.0.names(EXTENSION)?;
        if self.shore()?.is_some() {
            let (issued, revoked) = (IssuedList::read(&self.issued_path())?, self.revoked()?);
            let is_good = |one: &&Issued| revoked.iter().all(|other| other.serial != one.serial);
            names.extend(issued.of_vessels().filter(is_good).map(|one| one.name.clone()));
            names.sort();
            names.dedup();
        }
        Ok(names)
    }

    fn forget(&self, name: &str, now: UtcTime) -> anyhow::Result<bool> {
        let revoked = self.revoke(name, now)?;
        Ok(files::remove(&self.path(name))? || revoked)
    }

    fn knows_by_name(&self) -> bool {
        true
    }

    fn folder(&self) -> PathBuf {
        self.0.vpn().join("openvpn")
    }

    fn written(&self) -> Vec<PathBuf> {
        vec![self.folder()]
    }

    fn texts(&self, fleet: &Fleet, members: &[Member]) -> anyhow::Result<Vec<(PathBuf, String)>> {
        let shore = self.shore()?.with_context(|| state::no_key("the server"))?;
        let folder = self.folder();
        let mut texts = vec![
            (folder.join(format!("{INTERFACE}.conf")), openvpn::ashore(fleet, &shore)),
            (folder.join(openvpn::REVOKED), self.list()?.1),
        ];
        let place = |member: &Member| {
            let path = folder.join(openvpn::PLACES).join(&member.name);
            (path, openvpn::place(fleet.vpn.network, member.address))
        };
        texts.extend(members.iter().map(place));
        Ok(texts)
    }

    fn aboard(&self, fleet: &Fleet, vessel: &Vessel) -> anyhow::Result<(Part, String)> {
        let access = self.access(&vessel.name)?.with_context(|| state::no_key(&vessel.name))?;
        let shore = self.shore()?.with_context(|| state::no_key("the server"))?;
        // No certificate leaves that is not in the list of issued ones.
        self.enlist(clock::now())?;
        Ok((Part::OpenVpn, openvpn::aboard(fleet, vessel, &access.aboard, &shore.shield)))
    }

    fn doubts(&self, now: UtcTime) -> anyhow::Result<Vec<String>> {
        let Some(shore) = self.shore()? else { return Ok(Vec::new()) };
        let until = authority_validity(&shore.authority.certificate).map(|validity| validity.until);
        let near = until.filter(|until| *until - now < NOTICE_US);
        Ok(near.map(|until| {
            format!(
                "the certificates of the VPN end on {}: before that remove {}, apply the fleet file and bring every boat a new \
                 bundle",
                clock::written(until),
                self.shore_path().display()
            )
        })
        .into_iter()
        .collect())
    }

    fn tell_next(&self) {
        say!("  sudo rm -rf /etc/openvpn/server/{}", openvpn::PLACES);
        say!("  sudo cp -r {}/. /etc/openvpn/server/", self.folder().display());
        say!("  sudo systemctl enable openvpn-server@lutra && sudo systemctl restart openvpn-server@lutra");
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
    fn a_new_certificate_revokes_the_one_before_and_a_lost_list_is_told() {
        let data = tempfile::tempdir().unwrap();
        let files = Files::new(data.path(), None);
        let vpn = OpenVpn(&files);
        assert!(!vpn.has_shore().unwrap() && vpn.address("otter-01").unwrap().is_none());
        vpn.make_shore(now()).unwrap();
        vpn.give("otter-01", ADDRESS, true, now()).unwrap();
        vpn.give("otter-02", [10, 8, 0, 12].into(), true, now()).unwrap();
        let serial = || vpn.access("otter-01").unwrap().unwrap().serial;
        let first = serial();
        vpn.give("otter-01", ADDRESS, false, now()).unwrap();
        assert!(serial() == first && vpn.revoked().unwrap().is_empty(), "it moves with its certificate");
        // As after a kill between the list and the new certificate: the old one is good no more.
        vpn.revoke("otter-01", now()).unwrap();
        assert_eq!(vpn.address("otter-01").unwrap(), None);
        vpn.give("otter-01", ADDRESS, true, now()).unwrap();
        assert_ne!(serial(), first);
        let second = serial();
        vpn.give("otter-01", ADDRESS, true, now()).unwrap();
        assert!(vpn.forget("otter-02", now()).unwrap() && !vpn.forget("otter-02", now()).unwrap());
        let revoked = vpn.revoked().unwrap();
        let named: Vec<_> = revoked.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(named, ["otter-01", "otter-01", "otter-02"]);
        assert_eq!((revoked[0].serial, revoked[1].serial), (first, second));

        let list = fs::read_to_string(vpn.revoked_path()).unwrap();
        for cut_off in [None, Some(&list[..list.len() - 9])] {
            match cut_off {
                None => fs::remove_file(vpn.revoked_path()).unwrap(),
                Some(text) => fs::write(vpn.revoked_path(), text).unwrap(),
            }
            let why = vpn.address("otter-01").unwrap_err().to_string();
            assert!(why.contains("would be good again") && why.contains("backup"), "{why}");
        }
        // With a new authority all certificates are new, and those of before count as revoked.
        fs::remove_file(vpn.shore_path()).unwrap();
        assert_eq!(vpn.address("otter-01").unwrap(), None);
        vpn.make_shore(now()).unwrap();
        assert_eq!(vpn.address("otter-01").unwrap(), None, "another authority signed it");
        assert!(vpn.names().unwrap() == ["otter-01"] && vpn.revoked().unwrap().len() == 4);
        fs::write(vpn.path("otter-01"), "half").unwrap();
        let why = vpn.address("otter-01").err().unwrap().to_string();
        assert!(why.contains("otter-01.ovpn is damaged: remove it"), "{why}");
    }

    #[test]
    fn a_certificate_is_revoked_by_the_list_of_issued_ones_whatever_became_of_the_vessels_file() {
        let data = tempfile::tempdir().unwrap();
        let files = Files::new(data.path(), None);
        let vpn = OpenVpn(&files);
        vpn.make_shore(now()).unwrap();
        let mut serials = Vec::new();
        for (name, what) in [("otter-01", None), ("otter-02", Some("half")), ("otter-03", Some("other"))] {
            vpn.give(name, ADDRESS, true, now()).unwrap();
            serials.push(vpn.access(name).unwrap().unwrap().serial);
            match what {
                None => fs::remove_file(vpn.path(name)).unwrap(),
                Some(text) => fs::write(vpn.path(name), text).unwrap(),
            }
        }
        assert_eq!(vpn.names().unwrap(), ["otter-01", "otter-02", "otter-03"]);
        assert!(vpn.forget("otter-01", now()).unwrap() && !vpn.forget("otter-01", now()).unwrap());
        assert!(vpn.forget("otter-02", now()).unwrap());
        // A new certificate ends the one of the damaged file, too.
        vpn.give("otter-03", ADDRESS, true, now()).unwrap();
        let revoked: Vec<_> = vpn.revoked().unwrap().iter().map(|one| one.serial).collect();
        assert_eq!(revoked, serials);
        assert_eq!(vpn.names().unwrap(), ["otter-03"]);
    }

    #[test]
    fn certificates_of_before_the_list_are_taken_into_it_and_a_damaged_one_is_told() {
        let data = tempfile::tempdir().unwrap();
        let files = Files::new(data.path(), None);
        let vpn = OpenVpn(&files);
        vpn.make_shore(now()).unwrap();
        for name in ["otter-01", "otter-02"] {
            vpn.give(name, ADDRESS, true, now()).unwrap();
        }
        fs::remove_file(vpn.issued_path()).unwrap();
        fs::write(vpn.path("otter-02"), "half").unwrap();
        let why = vpn.forget("otter-02", now()).unwrap_err().to_string();
        assert!(why.contains("is in no list") && why.contains("makes a new authority"), "{why}");
        fs::remove_file(vpn.path("otter-01")).unwrap();
        assert!(vpn.forget("otter-01", now()).unwrap(), "the attempt before took it into the list");
    }

    #[test]
    fn the_end_of_the_authority_is_told_a_year_before() {
        let data = tempfile::tempdir().unwrap();
        let files = Files::new(data.path(), None);
        let vpn = OpenVpn(&files);
        vpn.make_shore(now()).unwrap();
        let in_days = |days: i64| UtcTime::from_micros(now().micros() + days * 86_400_000_000);
        assert!(vpn.doubts(now()).unwrap().is_empty() && vpn.doubts(in_days(3_200)).unwrap().is_empty());
        let told = vpn.doubts(in_days(3_400)).unwrap().concat();
        assert!(told.contains("end on") && told.contains("openvpn.key"), "{told}");
        let why = vpn.give("otter-01", ADDRESS, true, in_days(3_700)).unwrap_err().to_string();
        assert!(why.contains("authority ended on"), "{why}");
        let why = vpn.make_shore(UtcTime::from_micros(1)).unwrap_err().to_string();
        assert!(why.contains("no certificate is made"), "{why}");
    }
}
