//! What of a fleet's VPN must not be lost by chance: the server's key, a boat's place, and the steps by which root puts files
//! into force.

use crate::fleet::{Ashore, TWO, files, said};
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// The server's key of the VPN, by kind of VPN.
const KINDS: [(&str, &str, &str); 2] =
    [("wireguard", "server.key", "vpn"), ("openvpn", "openvpn.key", "ovpn")];

fn by(kind: &str, fleet: &str) -> String {
    fleet.replace("[vpn]\n", &format!("[vpn]\nkind = \"{kind}\"\n"))
}

/// The fleet of [`TWO`] without otter-2.
fn without_the_second() -> String {
    TWO.rsplit_once("[[vessel]]").unwrap().0.to_owned()
}

/// Addresses that the files of the VPN let in.
fn has_place(ashore: &Ashore, kind: &str, address: &str) -> bool {
    let all = files(&ashore.data().join("vpn"));
    let texts = all.iter().map(|(_, bytes)| String::from_utf8_lossy(bytes));
    let line = match kind {
        "wireguard" => format!("AllowedIPs = {address}/32"),
        _ => format!("ifconfig-push {address} "),
    };
    let texts: Vec<_> = texts.collect();
    let in_firewall = texts.iter().any(|text| text.contains("saddr != {") && text.contains(address));
    texts.iter().any(|text| text.contains(&line)) && in_firewall
}

#[test]
fn a_lost_key_of_the_server_is_not_replaced_where_boats_have_theirs_unless_a_person_says_so() {
    for (kind, key, _) in KINDS {
        let ashore = Ashore::new(&by(kind, TWO));
        ashore.apply(&[]);
        ashore.bundle("otter-1");
        let (file, path) = (ashore.file(), ashore.data().join("fleet").join(key));
        let apply = ["fleet", "apply", file.to_str().unwrap()];
        let refused = |arguments: &[&str]| {
            let before = files(&ashore.data().join("fleet"));
            let output = ashore.try_to(arguments);
            let told = said(&output);
            let remedy = format!(
                "restore it from the backup: /var/backups/lutra-server/fleet/{key} to {}",
                path.display()
            );
            assert!(!output.status.success() && told.contains(&remedy), "{kind} {arguments:?}: {told}");
            let cost =
                "--new-server-key` makes another, and puts every boat off the VPN until it has a new bundle";
            assert!(told.find(cost) > told.find(&remedy), "{told}");
            assert_eq!(files(&ashore.data().join("fleet")), before);
        };
        let whole = fs::read(&path).unwrap();
        for state in ["damaged", "lost"] {
            fs::remove_file(&path).unwrap();
            if state == "damaged" {
                fs::write(&path, "half").unwrap();
            }
            refused(&apply);
            refused(&[&apply[..], &["--dry-run"]].concat());
            refused(&["fleet", "rotate", "otter-1", "--vpn"]);
            refused(&["fleet", "bundle", "otter-1", "-o", ashore.beside("never.bundle").to_str().unwrap()]);
        }
        assert!(!ashore.beside("never.bundle").exists());
        fs::write(&path, whole).unwrap();
        assert!(ashore.apply(&[]).contains("nothing to do"), "by its remedy nothing changed");
        // All of the fleet's folder is lost: bundles were made, as app.db says.
        let (fleet, aside) = (ashore.data().join("fleet"), ashore.beside("aside"));
        fs::rename(&fleet, &aside).unwrap();
        fs::rename(ashore.data().join("vpn"), ashore.beside("aside-vpn")).unwrap();
        fs::create_dir(&fleet).unwrap();
        refused(&apply);
        fs::remove_dir(&fleet).unwrap();
        fs::rename(&aside, &fleet).unwrap();
        fs::remove_file(&path).unwrap();
        let told = ashore.apply(&["--new-server-key"]);
        assert!(told.contains("every boat needs a bundle"), "{told}");
        let kept = fs::read(&path).unwrap();
        let told = ashore.apply(&["--new-server-key"]);
        assert!(told.contains("the server has its key of the VPN, which stays"), "{told}");
        assert_eq!(fs::read(&path).unwrap(), kept);
        assert!(ashore.apply(&[]).contains("nothing to do"));
    }
}

#[test]
fn a_boat_that_left_the_file_keeps_its_place_though_its_own_file_is_damaged_or_lost() {
    for (kind, _, extension) in KINDS {
        for state in ["damaged", "lost"] {
            let ashore = Ashore::new(&by(kind, TWO));
            ashore.apply(&[]);
            let own = ashore.data().join(format!("fleet/otter-2.{extension}"));
            fs::remove_file(&own).unwrap();
            if state == "damaged" {
                fs::write(&own, "half").unwrap();
            }
            ashore.says(&by(kind, &without_the_second()));
            let file = ashore.file();
            for command in
                [&["fleet", "apply", file.to_str().unwrap()][..], &["fleet", "rotate", "otter-1", "--vpn"]]
            {
                let output = ashore.try_to(command);
                let told = said(&output);
                assert!(!output.status.success(), "{kind} {state}: {told}");
                assert!(
                    told.contains(&format!(
                        "otter-2.{extension} is {}",
                        if state == "damaged" { "damaged" } else { "not there" }
                    )),
                    "{told}"
                );
                assert!(told.contains("until then otter-2 keeps the place that it has"), "{told}");
                assert!(
                    has_place(&ashore, kind, "10.77.0.12") && has_place(&ashore, kind, "10.77.0.11"),
                    "{kind} {state}"
                );
            }
            // Its address is not free.
            ashore.says(&by(kind, &without_the_second().replace("10.77.0.11", "10.77.0.12")));
            let output = ashore.try_to(&["fleet", "apply", file.to_str().unwrap()]);
            assert!(
                said(&output).contains("10.77.0.12 is given to otter-1, and otter-2"),
                "{}",
                said(&output)
            );
            ashore.run(&["fleet", "revoke", "otter-2"]);
            assert!(!has_place(&ashore, kind, "10.77.0.12") && has_place(&ashore, kind, "10.77.0.11"));
        }
    }
}

/// The lines for root in what a command printed, and in a text of the manual.
fn steps_in(text: &str) -> Vec<&str> {
    let is_step = |line: &&str| line.starts_with("sudo ") || line.starts_with("if systemctl cat ");
    text.lines().map(str::trim).filter(is_step).collect()
}

/// Root's computer: below a folder, with programs that write down how they were called.
struct Root(TempDir);

impl Root {
    fn new() -> Self {
        let root = Self(TempDir::new().unwrap());
        for folder in ["bin", "etc/wireguard", "etc/openvpn/server/lutra.ccd"] {
            fs::create_dir_all(root.0.path().join(folder)).unwrap();
        }
        let log = root.0.path().join("log");
        let calls =
            [("sudo", "exec \"$@\"".to_owned()), ("systemctl", format!("echo \"$*\" >> {}", log.display()))];
        for (program, script) in calls {
            let path = root.0.path().join("bin").join(program);
            fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        }
        root
    }

    fn etc(&self) -> PathBuf {
        self.0.path().join("etc")
    }

    /// Runs the lines as a person pastes them, and returns whether they succeeded and which units were changed.
    fn paste(&self, lines: &[&str]) -> (bool, Vec<String>) {
        let log = self.0.path().join("log");
        fs::remove_file(&log).ok();
        let script = lines.join("\n").replace("/etc/", &format!("{}/", self.etc().display()));
        let path = format!("{}:{}", self.0.path().join("bin").display(), std::env::var("PATH").unwrap());
        let output = Command::new("bash").args(["-c", &script]).env("PATH", path).output().unwrap();
        let calls = fs::read_to_string(&log).unwrap_or_default();
        (output.status.success(), calls.lines().map(str::to_owned).collect())
    }
}

#[test]
fn the_steps_for_root_put_the_files_into_force_and_stop_at_the_first_failure() {
    let ashore = Ashore::new(&by("openvpn", TWO));
    let told = ashore.apply(&[]);
    let (steps, root) = (steps_in(&told), Root::new());
    let stale = root.etc().join("openvpn/server/lutra.ccd/lost.0123456789abcdef");
    fs::write(&stale, "ifconfig-push").unwrap();
    fs::write(root.etc().join("openvpn/server/office.conf"), "of another tunnel").unwrap();
    let up = ["enable openvpn-server@lutra", "restart openvpn-server@lutra", "restart lutra-server"];
    assert_eq!(root.paste(&steps), (true, up.map(str::to_owned).to_vec()), "{told}");
    let server = root.etc().join("openvpn/server");
    let copied: Vec<_> =
        files(&server).into_iter().filter(|(path, _)| !path.ends_with("office.conf")).collect();
    let from = ashore.data().join("vpn/openvpn");
    let moved = |all: &[(PathBuf, Vec<u8>)], base: &Path| -> Vec<_> {
        all.iter().map(|(path, bytes)| (path.strip_prefix(base).unwrap().to_owned(), bytes.clone())).collect()
    };
    assert_eq!(moved(&copied, &server), moved(&files(&from), &from));
    assert!(!stale.exists() && server.join("office.conf").exists());
    let mode = |path: &str| fs::metadata(server.join(path)).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode("lutra.ccd") & 0o055, 0o055, "OpenVPN as nobody reads it");
    assert_eq!(mode("lutra.conf"), 0o600);
    // What cannot be copied restarts nothing.
    fs::rename(&from, from.with_extension("away")).unwrap();
    assert_eq!(root.paste(&steps), (false, Vec::new()));
    fs::rename(from.with_extension("away"), &from).unwrap();

    // All boats are revoked: the folder is there, and empty.
    for name in ["otter-1", "otter-2"] {
        ashore.run(&["fleet", "revoke", name]);
    }
    let told = ashore.run(&["fleet", "revoke", "otter-1"]);
    let (succeeded, _) = root.paste(&steps_in(&told));
    assert!(succeeded && server.join("lutra.ccd").is_dir(), "{told}");
    assert!(files(&server.join("lutra.ccd")).is_empty());

    // Over to WireGuard, where OpenVPN runs.
    ashore.says(TWO);
    let told = ashore.apply(&[]);
    let steps = steps_in(&told);
    let (succeeded, calls) = root.paste(&steps);
    assert!(succeeded && !server.join("lutra.conf").exists(), "{told}");
    let calls: Vec<_> = calls.iter().map(String::as_str).collect();
    let over = [
        "cat openvpn-server@lutra",
        "disable --now openvpn-server@lutra",
        "enable wg-quick@lutra",
        "restart wg-quick@lutra",
    ];
    assert_eq!(calls, [&over[..], &up[2..]].concat());
    for name in ["lutra.conf", "lutra.nft"] {
        let (there, from) = (root.etc().join("wireguard").join(name), ashore.data().join("vpn").join(name));
        assert_eq!(fs::read(&there).unwrap(), fs::read(from).unwrap());
        assert_eq!(fs::metadata(there).unwrap().permissions().mode() & 0o777, 0o600);
    }
}

/// The block of the manual that begins with this line.
fn manual_steps(chapter: &str, begin: &str) -> Vec<String> {
    let text = fs::read_to_string(testkit::repository().join("docs/book/src").join(chapter)).unwrap();
    let from = text.find(begin).unwrap_or_else(|| panic!("{chapter} has no {begin}"));
    let block = text[from..].split("```").next().unwrap();
    block.lines().map(|line| line.trim().to_owned()).filter(|line| !line.is_empty()).collect()
}

#[test]
fn the_manual_has_the_steps_that_are_printed() {
    for (kind, chapter, begin) in [
        ("wireguard", "deployment.md", "sudo install -m 600 /var/lib/lutra-server/vpn/lutra.conf"),
        ("openvpn", "networks.md", "sudo rm -rf /etc/openvpn/server/lutra.ccd &&"),
    ] {
        let ashore = Ashore::new(&by(kind, TWO));
        let told = ashore.apply(&[]);
        let printed: Vec<String> = steps_in(&told)
            .iter()
            .map(|line| line.replace(ashore.data().to_str().unwrap(), "/var/lib/lutra-server"))
            .collect();
        assert_eq!(printed, manual_steps(chapter, begin));
    }
}

#[test]
fn remains_of_earlier_versions_are_removed_once_and_named() {
    let ashore = Ashore::new(&by("openvpn", TWO));
    ashore.apply(&[]);
    let remains = ["fleet/openvpn.crl", "fleet/openvpn.issued", "vpn/openvpn/lutra.crl"];
    for name in remains {
        fs::write(ashore.data().join(name), "of before").unwrap();
    }
    let told = ashore.apply(&[]);
    for path in remains.map(|name| ashore.data().join(name)) {
        assert!(
            told.contains(&format!("will remove {}, which an earlier version left", path.display())),
            "{told}"
        );
        assert!(!path.exists());
    }
    assert!(ashore.apply(&[]).contains("nothing to do"));
}

#[test]
fn a_bundle_says_when_the_files_of_the_vpn_are_not_those_of_the_fleet() {
    let ashore = Ashore::new(TWO);
    ashore.apply(&[]);
    let bundle = || {
        let output = ashore.beside("one.bundle");
        ashore.run(&["fleet", "bundle", "otter-1", "-o", output.to_str().unwrap()])
    };
    let note = "are not as the fleet file that was applied last says";
    assert!(!bundle().contains(note));
    fs::write(ashore.data().join("vpn/lutra.nft"), "by hand").unwrap();
    let told = bundle();
    assert!(told.contains(note) && told.contains("`lutra-server fleet apply`"), "{told}");
    let apart = ashore.beside("apart");
    ashore.apply(&["--vpn-dir", apart.to_str().unwrap()]);
    let output = ashore.beside("one.bundle");
    let told = ashore.run(&[
        "fleet",
        "bundle",
        "otter-1",
        "-o",
        output.to_str().unwrap(),
        "--vpn-dir",
        apart.to_str().unwrap(),
    ]);
    assert!(!told.contains(note), "{told}");
}

#[test]
fn the_folder_of_the_vpn_is_remembered_and_a_revoked_key_is_taken_out_of_the_files_that_are_read() {
    let ashore = Ashore::new(TWO);
    let apart = ashore.beside("apart");
    ashore.apply(&["--vpn-dir", apart.to_str().unwrap()]);
    let read = || fs::read_to_string(apart.join("lutra.conf")).unwrap();
    assert_eq!(read().matches("[Peer]").count(), 2, "{}", read());
    ashore.run(&["fleet", "revoke", "otter-2"]);
    assert_eq!(read().matches("[Peer]").count(), 1, "{}", read());
    assert!(!ashore.data().join("vpn").exists(), "a second set of files");
}
