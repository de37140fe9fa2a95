//! A fleet from one file, by the real programs: `lutra-server fleet` ashore, `lutra-agent provision` aboard, and an agent
//! that connects through the tunnel that both set up.

use crate::disk_full::Disk;
use crate::support::program::{Agent, Process, SERVER, Server, agent_program, until};
use crate::vpn::{Cable, daemon, ip, is_there, run as run_tool};
use std::fs;
use std::io::Write as _;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;
use testkit::{Need, absent};

/// A data folder and a fleet file beside it.
pub(crate) struct Ashore {
    folder: TempDir,
}

impl Ashore {
    pub(crate) fn new(fleet: &str) -> Self {
        let ashore = Self { folder: TempDir::new().unwrap() };
        ashore.says(fleet);
        ashore
    }

    /// The example of `deploy/`.
    fn example() -> Self {
        Self::new(&fs::read_to_string(testkit::repository().join("deploy/fleet.example.toml")).unwrap())
    }

    pub(crate) fn says(&self, fleet: &str) {
        fs::write(self.file(), fleet).unwrap();
    }

    pub(crate) fn file(&self) -> PathBuf {
        self.folder.path().join("fleet.toml")
    }

    pub(crate) fn data(&self) -> PathBuf {
        self.beside("data")
    }

    /// A place beside the data folder.
    pub(crate) fn beside(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn try_to(&self, arguments: &[&str]) -> Output {
        Command::new(SERVER).args(arguments).arg("--data").arg(self.data()).output().unwrap()
    }

    /// Output of a command on both streams; it must succeed.
    pub(crate) fn run(&self, arguments: &[&str]) -> String {
        let output = self.try_to(arguments);
        let said = said(&output);
        assert!(output.status.success(), "{arguments:?}: {said}");
        said
    }

    pub(crate) fn apply(&self, more: &[&str]) -> String {
        let file = self.file();
        self.run(&[&["fleet", "apply", file.to_str().unwrap()], more].concat())
    }

    /// A secret file of the fleet.
    fn kept(&self, name: &str) -> String {
        fs::read_to_string(self.data().join("fleet").join(name)).unwrap().trim().to_owned()
    }

    /// The bundle of a vessel and its passphrase.
    pub(crate) fn bundle(&self, name: &str) -> (PathBuf, String) {
        let file = self.folder.path().join(format!("{name}.bundle"));
        let output = self.try_to(&["fleet", "bundle", name, "-o", file.to_str().unwrap()]);
        assert!(output.status.success(), "{}", said(&output));
        (file, String::from_utf8(output.stdout).unwrap().trim().to_owned())
    }
}

pub(crate) fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// All files below a folder with their bytes.
pub(crate) fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.push((path.clone(), fs::read(&path).unwrap()));
        }
    }
    found.sort();
    found
}

/// Rows of app.db, such as the audit log and people.
fn rows(data: &Path, sql: &str) -> Vec<String> {
    let db = rusqlite::Connection::open(data.join("app.db")).unwrap();
    let mut asked = db.prepare(sql).unwrap();
    asked.query_map([], |row| row.get(0)).unwrap().map(Result::unwrap).collect()
}

#[test]
fn a_fleet_is_applied_once_and_a_second_run_changes_nothing() {
    let ashore = Ashore::example();
    let planned = ashore.apply(&["--dry-run"]);
    assert!(planned.contains("will make a link token for ntnu-otter-01"), "{planned}");
    assert!(!ashore.data().exists(), "nothing is written by --dry-run");

    let first = ashore.apply(&[]);
    let listed = ashore.run(&["vessel", "list"]);
    assert_eq!(listed.lines().count(), 4, "{listed}");
    assert!(listed.contains("ntnu-otter-04\t0x2813"), "{listed}");
    let kept: Vec<_> =
        ["fleet", "vpn"].iter().flat_map(|folder| files(&ashore.data().join(folder))).collect();
    for (path, bytes) in &kept {
        assert_eq!(fs::metadata(path).unwrap().permissions().mode() & 0o077, 0, "{}", path.display());
        let text = String::from_utf8_lossy(bytes);
        let secret = text.lines().next().unwrap_or_default();
        let is_secret = [".token", ".vpn", ".key"].iter().any(|end| path.to_str().unwrap().ends_with(end));
        assert!(!is_secret || secret.len() > 40 && !first.contains(secret), "{}", path.display());
    }
    assert_eq!(
        kept.len(),
        4 * 2 + 1 + 1 + 2,
        "tokens and keys, the server's, the file, WireGuard and firewall"
    );

    let second = ashore.apply(&[]);
    assert!(second.contains("nothing to do"), "{second}");
    let after: Vec<_> =
        ["fleet", "vpn"].iter().flat_map(|folder| files(&ashore.data().join(folder))).collect();
    assert_eq!(kept, after);
    let audited = rows(&ashore.data(), "SELECT action || ' ' || subject FROM audit ORDER BY id");
    assert!(audited.contains(&"token.make fleet: ntnu-otter-02".to_owned()), "{audited:?}");
    assert_eq!(audited.iter().filter(|line| line.starts_with("fleet.apply")).count(), 1);
}

#[test]
fn a_broken_file_is_told_whole_and_nothing_is_done() {
    let ashore = Ashore::example();
    let good = fs::read_to_string(ashore.file()).unwrap();
    let bad = good
        .replace("0x2811", "0x2810")
        .replace("10.8.0.13", "10.9.0.13")
        .replace("[common.limits]", "[common.limit]");
    ashore.says(&bad);
    for command in ["check", "apply"] {
        let output = ashore.try_to(&["fleet", command, ashore.file().to_str().unwrap()]);
        let said = said(&output);
        assert!(!output.status.success() && said.contains("3 problems"), "{said}");
        for told in
            ["0x2810 is ntnu-otter-01's", "not in 10.8.0.0/24", "did you mean `limits`?", "fleet.toml: line "]
        {
            assert!(said.contains(told), "{told}: {said}");
        }
    }
    assert!(!ashore.data().join("app.db").exists());
    // What the agent would refuse, or not know, is reported ashore.
    for (old, new, told) in [
        ("\"Air Draught\" = 1.5", "\"Air Drought\" = 1.5", "Air Drought"),
        ("\"Air Draught\" = 1.5", "\"Air Draught\" = -1", "Air Draught"),
    ] {
        ashore.says(&good.replace(old, new));
        let output = ashore.try_to(&["fleet", "check", ashore.file().to_str().unwrap()]);
        assert!(!output.status.success() && said(&output).contains(told), "{}", said(&output));
    }
}

#[test]
fn what_contradicts_the_database_is_told_and_nothing_is_done() {
    let ashore = Ashore::example();
    ashore.run(&["vessel", "add", "ntnu-otter-01", "0x2899"]);
    ashore.run(&["vessel", "add", "other", "0x2811"]);
    let output = ashore.try_to(&["fleet", "apply", ashore.file().to_str().unwrap()]);
    let said = said(&output);
    assert!(!output.status.success() && said.contains("2 conflicts"), "{said}");
    assert!(said.contains("vessel remove other"), "{said}");
    assert!(!ashore.data().join("fleet").exists());
}

#[test]
fn a_run_that_was_killed_is_finished_by_the_next() {
    let ashore = Ashore::example();
    ashore.apply(&[]);
    // A token file without its row in app.db; VPN files that were not written.
    let fleet = ashore.data().join("fleet");
    let known = ashore.kept("ntnu-otter-01.token");
    let unknown = known.replace(&known[known.len() - 4..], "0000");
    fs::write(fleet.join("ntnu-otter-01.token"), unknown).unwrap();
    fs::remove_file(ashore.data().join("vpn/lutra.conf")).unwrap();
    fs::remove_file(fleet.join("fleet.toml")).unwrap();
    let said = ashore.apply(&[]);
    assert!(
        said.contains("will make a link token for ntnu-otter-01\n") && said.contains("will write"),
        "{said}"
    );
    assert!(!said.contains("ntnu-otter-02"), "{said}");
    assert!(ashore.apply(&[]).contains("nothing to do"));
    // The server's own key has its line, once.
    let server_key = "SELECT subject FROM audit WHERE action = 'fleet.vpn' AND subject = 'the server'";
    assert_eq!(rows(&ashore.data(), server_key).len(), 1);
    // A VPN key that cannot be written, as after a kill before it: the audit log has it already.
    let lines = "SELECT subject FROM audit WHERE action IN ('fleet.vpn', 'fleet.rotate')";
    let before = rows(&ashore.data(), lines).len();
    let key = ashore.kept("ntnu-otter-03.vpn");
    let obstacle = fleet.join("ntnu-otter-03.vpn.new");
    fs::create_dir_all(obstacle.join("full")).unwrap();
    let rotated = ashore.try_to(&["fleet", "rotate", "ntnu-otter-03", "--vpn"]);
    assert!(!rotated.status.success() && ashore.kept("ntnu-otter-03.vpn") == key);
    fs::remove_file(fleet.join("ntnu-otter-03.vpn")).unwrap();
    let applied = ashore.try_to(&["fleet", "apply", ashore.file().to_str().unwrap()]);
    assert!(!applied.status.success() && !fleet.join("ntnu-otter-03.vpn").exists());
    let told = rows(&ashore.data(), lines);
    assert_eq!(told[before..], ["ntnu-otter-03: VPN key", "ntnu-otter-03"]);
    fs::remove_dir_all(obstacle).unwrap();
    ashore.apply(&[]);
    // The token that is no longer stored expires.
    let endless = "SELECT CAST(count(*) AS TEXT) FROM token WHERE vessel = 0x2810 AND expires_us IS NULL";
    assert_eq!(rows(&ashore.data(), endless), ["1"]);
}

#[test]
fn secrets_are_rotated_with_a_grace_and_revoked_at_once() {
    let ashore = Ashore::example();
    ashore.apply(&[]);
    let (token, key) = (ashore.kept("ntnu-otter-01.token"), ashore.kept("ntnu-otter-01.vpn"));
    let said = ashore.run(&["fleet", "rotate", "ntnu-otter-01", "--token"]);
    assert!(said.contains("its old one is good until"), "{said}");
    assert_ne!(ashore.kept("ntnu-otter-01.token"), token);
    let count = "SELECT CAST(count(*) AS TEXT) FROM token WHERE vessel = 0x2810";
    let never = format!("{count} AND expires_us IS NULL");
    assert_eq!(
        (rows(&ashore.data(), count), rows(&ashore.data(), &never)),
        (vec!["2".to_owned()], vec!["1".to_owned()])
    );
    let said = ashore.run(&["fleet", "rotate", "ntnu-otter-01", "--token", "--vpn", "--grace-days", "0"]);
    assert!(said.contains("is off the VPN") && said.contains("opens nothing any more"), "{said}");
    assert_ne!(ashore.kept("ntnu-otter-01.vpn"), key);
    assert_eq!(rows(&ashore.data(), count), ["1"]);
    let conf = fs::read_to_string(ashore.data().join("vpn/lutra.conf")).unwrap();
    assert!(conf.contains("10.8.0.11/32"));

    // A vessel that leaves the file keeps its access until it is revoked by name.
    let fleet = fs::read_to_string(ashore.file()).unwrap();
    let left = fleet.replace(
        "[[vessel]]\nname = \"ntnu-otter-01\"\nimc_address = 0x2810\nvpn_address = \"10.8.0.11\"\n",
        "",
    );
    assert_ne!(fleet, left);
    ashore.says(&left);
    let said = ashore.apply(&[]);
    assert!(
        said.contains("ntnu-otter-01 is not in the file and keeps its link token and its place in the VPN"),
        "{said}"
    );
    let conf = || fs::read_to_string(ashore.data().join("vpn/lutra.conf")).unwrap();
    assert!(conf().contains("10.8.0.11/32"));
    let said = ashore.apply(&["--revoke", "ntnu-otter-01"]);
    assert!(said.contains("1 link token revoked"), "{said}");
    assert!(!conf().contains("10.8.0.11/32") && conf().contains("10.8.0.12/32"));
    assert_eq!(rows(&ashore.data(), count), ["0"]);
    assert!(!ashore.data().join("fleet/ntnu-otter-01.token").exists());
    let said = ashore.run(&["fleet", "revoke", "ntnu-otter-02"]);
    assert!(said.contains("still in the fleet file") && !conf().contains("10.8.0.12/32"), "{said}");
    let audited = rows(
        &ashore.data(),
        "SELECT subject FROM audit WHERE action IN ('fleet.rotate', 'fleet.revoke') ORDER BY id",
    );
    assert_eq!(
        audited,
        [
            "ntnu-otter-01: link token",
            "ntnu-otter-01: VPN key",
            "ntnu-otter-01: link token",
            "ntnu-otter-01",
            "ntnu-otter-02"
        ]
    );
    let output = ashore.try_to(&["fleet", "bundle", "ntnu-otter-02", "-o", "never.bundle"]);
    assert!(
        !output.status.success() && self::said(&output).contains("has no link token"),
        "{}",
        self::said(&output)
    );
}

/// The example's fleet with OpenVPN.
fn by_openvpn(fleet: &str) -> String {
    fleet.replace("[vpn]\n", "[vpn]\nkind = \"openvpn\"\n")
}

/// Names of the certificates that OpenVPN lets in, in order.
fn let_in(ashore: &Ashore) -> Vec<String> {
    let places = files(&ashore.data().join("vpn/openvpn/lutra.ccd"));
    places.iter().map(|(path, _)| path.file_name().unwrap().to_str().unwrap().to_owned()).collect()
}

/// How many link tokens vessels have.
fn link_tokens(ashore: &Ashore) -> Vec<String> {
    rows(&ashore.data(), "SELECT CAST(count(*) AS TEXT) FROM token WHERE vessel IS NOT NULL")
}

#[test]
fn a_boat_whose_own_file_is_damaged_is_revoked_and_one_of_another_boat_stays_in() {
    let ashore = Ashore::new(&by_openvpn(TWO));
    ashore.apply(&[]);
    let before = let_in(&ashore);
    assert!(before.len() == 2 && before[1].starts_with("otter-2."), "{before:?}");
    for name in ["otter-1", "otter-2"] {
        fs::write(ashore.data().join(format!("fleet/{name}.ovpn")), [0xFF, 0xFE]).unwrap();
    }
    let output = ashore.try_to(&["fleet", "revoke", "otter-1"]);
    let told = said(&output);
    assert!(!output.status.success() && told.contains("otter-1: 1 link token revoked"), "{told}");
    assert!(told.contains("not done: ") && told.contains("otter-2.ovpn is damaged"), "{told}");
    assert!(told.contains("chmod -R a+rX") && told.contains("restart openvpn-server@lutra"), "{told}");
    assert_eq!(let_in(&ashore), before[1..]);
    // A new key for one boat, while the file of another is damaged, has its steps.
    ashore.run(&["fleet", "revoke", "otter-2"]);
    ashore.apply(&[]);
    fs::write(ashore.data().join("fleet/otter-2.ovpn"), "half").unwrap();
    let before = let_in(&ashore);
    let output = ashore.try_to(&["fleet", "rotate", "otter-1", "--vpn"]);
    let told = said(&output);
    assert!(!output.status.success() && told.contains("otter-2.ovpn is damaged"), "{told}");
    assert!(told.contains("restart openvpn-server@lutra") && told.contains("fleet bundle otter-1"), "{told}");
    assert!(let_in(&ashore)[0] != before[0] && let_in(&ashore)[1] == before[1]);
    // By its remedy.
    fs::remove_file(ashore.data().join("fleet/otter-2.ovpn")).unwrap();
    ashore.apply(&[]);
    assert!(let_in(&ashore).len() == 2 && let_in(&ashore)[1] != before[1]);
}

#[test]
fn a_part_that_cannot_be_done_for_one_boat_holds_up_no_other_and_can_be_done_again() {
    let third = "[[vessel]]\nname = \"otter-3\"\nimc_address = 0x2812\nvpn_address = \"10.77.0.13\"\n";
    let ashore = Ashore::new(&by_openvpn(&format!("{TWO}{third}")));
    ashore.apply(&[]);
    // It cannot be removed as a file.
    let obstacle = ashore.data().join("fleet/otter-1.ovpn");
    fs::remove_file(&obstacle).unwrap();
    fs::create_dir(&obstacle).unwrap();
    let common = TWO.split_once("[[vessel]]").unwrap().0;
    ashore.says(&by_openvpn(&format!("{common}{third}")));
    let file = ashore.file();
    let revoke = ["fleet", "apply", file.to_str().unwrap(), "--revoke", "otter-1", "--revoke", "otter-2"];
    let output = ashore.try_to(&revoke);
    let told = said(&output);
    assert!(!output.status.success() && told.contains("not done: otter-1: openvpn: cannot remove"), "{told}");
    assert!(told.contains("lutra.ccd -name 'otter-1.????????????????' -delete"), "{told}");
    assert!(told.contains("run `lutra-server fleet revoke otter-1` and"), "{told}");
    assert!(told.contains("restart openvpn-server@lutra"), "{told}");
    assert_eq!(link_tokens(&ashore), ["1"], "otter-3 keeps its own");
    let places = let_in(&ashore);
    assert!(places.len() == 1 && places[0].starts_with("otter-3."), "{places:?}");
    fs::remove_dir(&obstacle).unwrap();
    ashore.apply(&["--revoke", "otter-1", "--revoke", "otter-2"]);
    assert!(ashore.apply(&[]).contains("nothing to do"));
}

#[test]
fn a_revocation_without_the_servers_key_takes_the_boats_place_and_says_what_is_left() {
    let ashore = Ashore::new(&by_openvpn(TWO));
    ashore.apply(&[]);
    fs::remove_file(ashore.data().join("fleet/openvpn.key")).unwrap();
    let output = ashore.try_to(&["fleet", "revoke", "otter-1"]);
    let text = said(&output);
    assert!(!output.status.success() && text.contains("otter-1: 1 link token revoked"), "{text}");
    assert!(text.contains("openvpn.key is not there"), "{text}");
    assert!(text.contains("lutra.ccd -name 'otter-1.????????????????' -delete"), "{text}");
    let places = let_in(&ashore);
    assert!(places.len() == 1 && places[0].starts_with("otter-2."), "{places:?}");
}

#[test]
fn a_bundle_that_waits_for_its_passphrase_holds_up_no_revocation() {
    let ashore = Ashore::new(TWO);
    ashore.apply(&[]);
    let (pipe, bundle) = (ashore.beside("passphrase"), ashore.beside("otter-1.bundle"));
    run_tool("mkfifo", &[pipe.to_str().unwrap()]).unwrap();
    let mut command = Command::new(SERVER);
    command.args(["fleet", "bundle", "otter-1", "--passphrase-file"]).arg(&pipe).arg("-o").arg(&bundle);
    let mut waiting = command.arg("--data").arg(ashore.data()).stderr(Stdio::null()).spawn().unwrap();
    // Opens once the command reads from it.
    let mut passphrase = fs::OpenOptions::new().write(true).open(&pipe).unwrap();
    ashore.run(&["fleet", "revoke", "otter-2"]);
    passphrase.write_all(b"a passphrase of some length\n").unwrap();
    drop(passphrase);
    assert!(waiting.wait().unwrap().success() && bundle.exists());
}

/// Takes the five seconds for which a command waits for another one.
#[test]
fn link_tokens_of_a_lost_boat_end_though_another_command_holds_the_fleet() {
    let ashore = Ashore::new(TWO);
    ashore.apply(&[]);
    let held = fs::File::open(ashore.data().join("fleet.lock")).unwrap();
    held.lock().unwrap();
    let output = ashore.try_to(&["fleet", "revoke", "otter-1"]);
    let told = said(&output);
    assert!(!output.status.success() && told.contains("otter-1: 1 link token revoked"), "{told}");
    assert!(told.contains("not done: otter-1: stored link token and keys of the VPN: "), "{told}");
    assert_eq!(link_tokens(&ashore), ["1"]);
    drop(held);
    let told = ashore.run(&["fleet", "revoke", "otter-1"]);
    assert!(told.contains("its key by wireguard is ended"), "{told}");
}

#[test]
fn a_fleet_that_goes_over_to_the_other_kind_of_vpn_leaves_no_key_of_the_first_one_good() {
    let ashore = Ashore::new(TWO);
    ashore.apply(&[]);
    let (fleet, vpn) = (ashore.data().join("fleet"), ashore.data().join("vpn"));
    assert!(vpn.join("lutra.conf").exists() && fleet.join("otter-1.vpn").exists());
    ashore.says(&by_openvpn(TWO));
    let told = ashore.apply(&[]);
    assert!(told.contains("will end the key of otter-1 by wireguard"), "{told}");
    assert!(told.contains("rm -f /etc/wireguard/lutra.conf"), "{told}");
    for gone in [fleet.join("otter-1.vpn"), fleet.join("otter-2.vpn"), vpn.join("lutra.conf")] {
        assert!(!gone.exists(), "{}", gone.display());
    }
    assert!(ashore.apply(&[]).contains("nothing to do"));

    // The way back, with remains that are damaged.
    ashore.says(TWO);
    for name in ["otter-1.ovpn", "openvpn.key"] {
        fs::write(fleet.join(name), "half").unwrap();
    }
    ashore.apply(&[]);
    assert!(!vpn.join("openvpn").exists() && vpn.join("lutra.conf").exists());
    assert!(!fleet.join("otter-1.ovpn").exists() && !fleet.join("otter-2.ovpn").exists());
    assert!(ashore.apply(&[]).contains("nothing to do"));
    fs::remove_file(fleet.join("openvpn.key")).unwrap();
    // A key of the other kind that an earlier version left ends with a rotation.
    ashore.says(&by_openvpn(TWO));
    ashore.apply(&[]);
    fs::write(fleet.join("otter-1.vpn"), "of before").unwrap();
    ashore.run(&["fleet", "rotate", "otter-1", "--vpn"]);
    assert!(!fleet.join("otter-1.vpn").exists());
    let ended = rows(&ashore.data(), "SELECT subject FROM audit WHERE action = 'fleet.revoke' ORDER BY id");
    let (wireguard, openvpn) = ("key by wireguard", "key by openvpn");
    let expected =
        [("otter-1", wireguard), ("otter-2", wireguard), ("otter-1", openvpn), ("otter-2", openvpn)];
    let expected = expected.map(|(name, key)| format!("{name}: {key}"));
    assert_eq!(ended[..4], expected);
    assert_eq!(ended[4..], expected[..2].iter().chain(&expected[..1]).cloned().collect::<Vec<_>>());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_revoked_boat_is_put_out_by_the_running_server_and_let_in_no_more() {
    let Some(program) = agent_program() else { return };
    let (ashore, aboard) = (Ashore::new(TWO), TempDir::new().unwrap());
    ashore.apply(&[]);
    let server = Server::start(&ashore.data());
    let token = ashore.kept("otter-1.token");
    let mut agent = Agent::start(&program, aboard.path(), server.web, &token);
    let said = |what: &str| server.log().matches(what).count();
    until("the link stands", || (said("the link stands") == 1).then_some(())).await;
    ashore.run(&["fleet", "revoke", "otter-1"]);
    until("put out", || (said("the link is down") == 1).then_some(())).await;
    until("refused", || agent.errors().contains("/link answers 401").then_some(())).await;
    // The same token in a new start of the agent.
    agent.process.kill();
    let again = TempDir::new().unwrap();
    let agent = Agent::start(&program, again.path(), server.web, &token);
    until("refused once more", || agent.errors().contains("/link answers 401").then_some(())).await;
    assert_eq!(said("the link stands"), 1);
}

/// A root on which the agent's package is installed.
pub(crate) fn boat() -> TempDir {
    let root = TempDir::new().unwrap();
    install(root.path());
    root
}

/// Installs the package's files.
fn install(root: &Path) {
    fs::create_dir_all(root.join("etc/lutra")).unwrap();
    let packaged = testkit::repository().join("vehicle-agent/etc/otter.ini");
    fs::copy(packaged, root.join("etc/lutra/agent.ini")).unwrap();
    let (user, group) = (rustix::process::geteuid().as_raw(), rustix::process::getegid().as_raw());
    fs::write(root.join("etc/passwd"), format!("lutra-agent:x:{user}:{group}:::\n")).unwrap();
}

pub(crate) fn provision(
    program: &Path,
    bundle: &Path,
    passphrase: &str,
    root: &Path,
    more: &[&str],
) -> Output {
    let secret = root.join("passphrase");
    fs::write(&secret, passphrase).unwrap();
    let mut command = Command::new(program);
    command
        .arg("provision")
        .arg(bundle)
        .arg("--root")
        .arg(root)
        .arg("--passphrase-file")
        .arg(&secret)
        .args(more);
    let output = command.stdin(Stdio::null()).output().unwrap();
    fs::remove_file(secret).unwrap();
    output
}

#[test]
fn a_bundle_made_ashore_is_unpacked_aboard() {
    let Some(program) = agent_program() else { return };
    let ashore = Ashore::example();
    ashore.apply(&[]);
    let (bundle, passphrase) = ashore.bundle("ntnu-otter-02");
    assert_eq!(fs::metadata(&bundle).unwrap().permissions().mode() & 0o077, 0);
    let root = boat();
    let before = files(root.path());
    for (passphrase, more, told) in [
        ("another passphrase", &[][..], "does not open this bundle"),
        (&passphrase, &["--check"], "would write"),
    ] {
        let output = provision(&program, &bundle, passphrase, root.path(), more);
        assert!(said(&output).contains(told), "{}", said(&output));
        assert_eq!(files(root.path()), before, "nothing is written");
    }
    let output = provision(&program, &bundle, &passphrase, root.path(), &[]);
    assert!(output.status.success(), "{}", said(&output));
    assert!(said(&output).contains("this computer is ntnu-otter-02 (0x2811)"), "{}", said(&output));
    let token = ashore.kept("ntnu-otter-02.token");
    assert_eq!(fs::read_to_string(root.path().join("etc/lutra/lutra.token")).unwrap().trim(), token);
    assert!(!said(&output).contains(&token));
    let again = said(&provision(&program, &bundle, &passphrase, root.path(), &[]));
    assert!(again.contains("nothing to do: this computer is ntnu-otter-02 already"), "{again}");
    let (other, passphrase) = ashore.bundle("ntnu-otter-03");
    let refused = provision(&program, &other, &passphrase, root.path(), &[]);
    assert!(
        !refused.status.success() && said(&refused).contains("this computer is ntnu-otter-02"),
        "{}",
        said(&refused)
    );
    let whole = fs::read(&other).unwrap();
    fs::write(&other, &whole[..whole.len() - 9]).unwrap();
    let refused = provision(&program, &other, &passphrase, boat().path(), &[]);
    assert!(!refused.status.success() && said(&refused).contains("is cut short"), "{}", said(&refused));
}

#[test]
fn a_full_disk_takes_nothing_of_a_bundle_and_all_of_it_once_there_is_room() {
    let Some(program) = agent_program() else { return };
    let Some(disk) = Disk::mount() else { return };
    let (ashore, root) = (Ashore::example(), disk.data());
    ashore.apply(&[]);
    let (bundle, passphrase) = ashore.bundle("ntnu-otter-01");
    let secret = ashore.folder.path().join("passphrase");
    fs::write(&secret, passphrase).unwrap();
    install(&root);
    let bring = || {
        let mut command = Command::new(&program);
        command.arg("provision").arg(&bundle).arg("--root").arg(&root).arg("--passphrase-file").arg(&secret);
        command.output().unwrap()
    };
    disk.fill();
    let (before, output) = (files(&root), bring());
    assert!(!output.status.success() && said(&output).contains("bring old logs ashore"), "{}", said(&output));
    assert_eq!(files(&root), before);
    disk.make_room();
    assert!(bring().status.success());
    assert!(root.join("etc/lutra/vessel.ini").exists());
}

#[test]
fn an_encrypted_link_brings_its_authority_aboard() {
    let Some(program) = agent_program() else { return };
    let example = fs::read_to_string(testkit::repository().join("deploy/fleet.example.toml")).unwrap();
    let ashore = Ashore::new(&example.replace("encrypted = false", "encrypted = true"));
    let said_first = ashore.apply(&[]);
    assert!(said_first.contains("this server has no certificate"), "{said_first}");
    let output = ashore.try_to(&["fleet", "bundle", "ntnu-otter-01", "-o", "never.bundle"]);
    assert!(!output.status.success() && said(&output).contains("tls init"), "{}", said(&output));
    ashore.run(&["tls", "init", "--name", "10.8.0.1"]);
    let (bundle, passphrase) = ashore.bundle("ntnu-otter-01");
    let root = boat();
    let output = provision(&program, &bundle, &passphrase, root.path(), &[]);
    assert!(output.status.success(), "{}", said(&output));
    let brought = fs::read(root.path().join("etc/lutra/ca.pem")).unwrap();
    assert_eq!(brought, fs::read(ashore.data().join("tls/ca.pem")).unwrap());
    let overlay = fs::read_to_string(root.path().join("etc/lutra/vessel.ini")).unwrap();
    assert!(overlay.contains("URL = wss://10.8.0.1:8080/link\n"), "{overlay}");
    assert!(overlay.contains("Certificate Authority = ca.pem\n"), "{overlay}");
}

/// A fleet of two simulated boats whose shore is at 192.0.2.1, as set up by [`Cable`].
pub(crate) const TWO: &str = "
[server]
public_name = \"192.0.2.1\"
[vpn]
network = \"10.77.0.0/24\"
server_address = \"10.77.0.1\"
keepalive_s = 1
[common]
profile = \"Simulation\"
[[vessel]]
name = \"otter-1\"
imc_address = 0x2810
vpn_address = \"10.77.0.11\"
[[vessel]]
name = \"otter-2\"
imc_address = 0x2811
vpn_address = \"10.77.0.12\"
";

/// Applies a `wg-quick` file by hand: this kernel has no WireGuard, and names of interfaces must be unique here.
async fn tunnel(cable: &Cable, side: char, file: &Path, folder: &Path) -> Process {
    let (namespace, other) =
        if side == 's' { (cable.shore(), "10.77.0.0/24") } else { (cable.vessel(), "10.77.0.1/32") };
    let device = cable.tunnel(side);
    let text = fs::read_to_string(file).unwrap();
    let (address, plain): (Vec<&str>, Vec<&str>) = text
        .lines()
        .filter(|line| !line.starts_with("PreUp = "))
        .partition(|line| line.starts_with("Address = "));
    let plain_file = folder.join(format!("{side}.wg"));
    fs::write(&plain_file, plain.join("\n") + "\n").unwrap();
    let running = daemon(&namespace, "wireguard-go", &["-f", &device], &folder.join(format!("{side}.log")));
    let set = ["netns", "exec", &namespace, "wg", "setconf", &device, plain_file.to_str().unwrap()];
    until("WireGuard up", || run_tool("ip", &set).ok()).await;
    ip(&format!("-n {namespace} addr add {} dev {device}", &address[0]["Address = ".len()..])).unwrap();
    ip(&format!("-n {namespace} link set {device} up")).unwrap();
    ip(&format!("-n {namespace} route replace {other} dev {device}")).unwrap();
    running
}

/// Whether a connection from the boat reaches this port of the shore; nothing listens on it, so that a permitted connection
/// is refused at once, and a blocked one gets no answer.
fn is_let_through(cable: &Cable, port: u16) -> bool {
    let script = format!("timeout 2 bash -c 'exec 3<>/dev/tcp/10.77.0.1/{port}' 2>&1; test $? -ne 124");
    Cable::inside(&cable.vessel(), "bash").args(["-c", &script]).status().unwrap().success()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_provisioned_agent_comes_in_through_the_tunnel_of_the_fleet_and_reaches_nothing_else() {
    let Some(program) = agent_program() else { return };
    if !is_there("wireguard-go") || !is_there("wg") {
        absent(Need::Wireguard, "apt-get install wireguard-go wireguard-tools");
        return;
    }
    let Some(cable) = Cable::lay("fleet") else { return };
    let (ashore, root) = (Ashore::new(TWO), boat());
    ashore.apply(&[]);
    let bring = || {
        let (bundle, passphrase) = ashore.bundle("otter-1");
        let output = provision(&program, &bundle, &passphrase, root.path(), &[]);
        assert!(output.status.success(), "{}", said(&output));
    };
    bring();
    let in_force = root.path().join("etc/wireguard/lutra.conf");

    let shore = tunnel(&cable, 's', &ashore.data().join("vpn/lutra.conf"), ashore.folder.path()).await;
    let boat = tunnel(&cable, 'v', &in_force, ashore.folder.path()).await;
    let firewall = is_there("nft");
    if firewall {
        let rules = fs::read_to_string(ashore.data().join("vpn/lutra.nft")).unwrap();
        let file = ashore.folder.path().join("lutra.nft");
        fs::write(&file, rules.replace("\"lutra\"", &format!("\"{}\"", cable.tunnel('s')))).unwrap();
        for (how, why) in [("-c", "syntax"), ("-e", "in force"), ("-e", "in force again")] {
            let shore = cable.shore();
            let load = ["netns", "exec", &shore, "nft", how, "-f", file.to_str().unwrap()];
            run_tool("ip", &load).unwrap_or_else(|error| panic!("{why}: {error}"));
        }
    } else {
        absent(Need::Nftables, "apt-get install nftables");
    }

    let (mut server, _agent) = link(&cable, &ashore, &program, root.path()).await;
    if firewall {
        assert!(is_let_through(&cable, 8080), "the link's door is open");
        assert!(!is_let_through(&cable, 8081), "no other is");
    }

    // The server gets another key: the boat is out until it has the bundle made after that.
    drop((shore, boat));
    fs::remove_file(ashore.data().join("fleet/server.key")).unwrap();
    let told = ashore.apply(&["--new-server-key"]);
    assert!(told.contains("every boat needs a bundle"), "{told}");
    let _shore = tunnel(&cable, 's', &ashore.data().join("vpn/lutra.conf"), ashore.folder.path()).await;
    let boat = tunnel(&cable, 'v', &in_force, ashore.folder.path()).await;
    assert!(!is_let_through(&cable, 8080), "the server of before is not there any more");
    drop(boat);
    bring();
    let _boat = tunnel(&cable, 'v', &in_force, ashore.folder.path()).await;
    assert!(is_let_through(&cable, 8080));

    // A key that is revoked opens nothing any more, whatever the boat tries.
    ashore.run(&["fleet", "revoke", "otter-1"]);
    let stood = server.log().matches("the link stands").count();
    let file = ashore.folder.path().join("revoked.wg");
    let conf = fs::read_to_string(ashore.data().join("vpn/lutra.conf")).unwrap();
    let plain =
        conf.lines().filter(|line| !["PreUp = ", "Address = "].iter().any(|key| line.starts_with(key)));
    fs::write(&file, plain.collect::<Vec<_>>().join("\n") + "\n").unwrap();
    let (shore, device) = (cable.shore(), cable.tunnel('s'));
    run_tool("ip", &["netns", "exec", &shore, "wg", "syncconf", &device, file.to_str().unwrap()]).unwrap();
    assert!(!is_let_through(&cable, 8080), "its packets are dropped");
    assert_eq!(server.log().matches("the link stands").count(), stood);
    server.process.terminate();
}

/// Starts the server in the shore's namespace and the provisioned agent in the vessel's; the link stands.
async fn link(cable: &Cable, ashore: &Ashore, program: &Path, root: &Path) -> (Server, Process) {
    let beyond = ["--set", "http.plain_beyond_loopback=true"];
    let server =
        Server::start_by(Cable::inside(&cable.shore(), SERVER), &ashore.data(), "10.77.0.1:8080", &beyond);
    let mut agent = Cable::inside(&cable.vessel(), program.to_str().unwrap());
    agent.arg("run").arg(root.join("etc/lutra/vessel.ini"));
    agent.args(["--quiet", "--data"]).arg(root.join("sailing"));
    let agent = Process(agent.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
    until("the link stands", || server.log().contains("the link stands").then_some(())).await;
    (server, agent)
}

/// The folder of OpenVPN's files as root copies it, with the name of the tunnel's interface that is unique on this computer.
fn put_openvpn(cable: &Cable, side: char, from: &Path, to: &Path) {
    for (path, bytes) in files(from) {
        let to = to.join(path.strip_prefix(from).unwrap());
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let tunnel = cable.tunnel(side);
        let text = text.replace("\ndev lutra\n", &format!("\ndev {tunnel}\n"));
        fs::write(to, text.replace("\"lutra\"", &format!("\"{tunnel}\""))).unwrap();
    }
}

/// Starts OpenVPN by the configuration `lutra.conf` in this folder; its log is beside it.
fn openvpn(namespace: &str, folder: &Path) -> Process {
    let arguments = ["--cd", folder.to_str().unwrap(), "--config", "lutra.conf"];
    daemon(namespace, "openvpn", &arguments, &folder.join("log"))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn by_openvpn_a_provisioned_agent_comes_in_and_a_replaced_certificate_does_not() {
    let Some(program) = agent_program() else { return };
    if !is_there("openvpn") || !is_there("nft") {
        absent(Need::Openvpn, "apt-get install openvpn nftables");
        return;
    }
    let Some(cable) = Cable::lay("provisioned") else { return };
    let (ashore, root) = (Ashore::new(&TWO.replace("[vpn]", "[vpn]\nkind = \"openvpn\"")), boat());
    let told = ashore.apply(&[]);
    assert!(told.contains("openvpn-server@lutra") && !told.contains("wg-quick"), "{told}");
    assert!(ashore.apply(&[]).contains("nothing to do"));
    let bring = || {
        let (bundle, passphrase) = ashore.bundle("otter-1");
        let output = provision(&program, &bundle, &passphrase, root.path(), &[]);
        assert!(output.status.success(), "{}", said(&output));
    };
    bring();
    let (shore, boat) = (ashore.folder.path().join("shore"), ashore.folder.path().join("boat"));
    let (from, aboard) = (ashore.data().join("vpn/openvpn"), root.path().join("etc/openvpn/client"));
    let log = |folder: &Path| fs::read_to_string(folder.join("log")).unwrap();
    put_openvpn(&cable, 's', &from, &shore);
    put_openvpn(&cable, 'v', &aboard, &boat);
    // As /etc/openvpn/server: OpenVPN has no rights of root once the tunnel is open.
    for folder in [ashore.folder.path(), &shore] {
        fs::set_permissions(folder, fs::Permissions::from_mode(0o711)).unwrap();
    }
    let running = openvpn(&cable.shore(), &shore);
    let up = |folder: &Path| log(folder).contains("Initialization Sequence Completed").then_some(());
    until("OpenVPN up ashore", || up(&shore)).await;
    let vessel = openvpn(&cable.vessel(), &boat);
    until("OpenVPN up aboard", || up(&boat)).await;
    assert!(log(&shore).contains("UID set to nobody"), "{}", log(&shore));
    let own = ip(&format!("-n {} -o addr show dev {}", cable.vessel(), cable.tunnel('v'))).unwrap();
    assert!(own.contains("10.77.0.11/24"), "{own}");

    let (mut server, agent) = link(&cable, &ashore, &program, root.path()).await;
    assert!(is_let_through(&cable, 8080), "the link's door is open");
    assert!(!is_let_through(&cable, 8081), "no other is");
    drop(agent);
    server.process.terminate();

    // The vessel gets a new certificate: its present one has no place then, and is refused by that alone. The boat goes on asking.
    drop(vessel);
    ashore.run(&["fleet", "rotate", "otter-1", "--vpn"]);
    let present = let_in(&ashore);
    fs::remove_dir_all(shore.join("lutra.ccd")).unwrap();
    put_openvpn(&cable, 's', &from, &shore);
    let refused = || log(&shore).matches("--client-config-dir authentication failed for common name").count();
    let vessel = openvpn(&cable.vessel(), &boat);
    until("refused, twice", || (refused() >= 2).then_some(())).await;
    assert!(up(&boat).is_none(), "{}", log(&boat));
    drop(vessel);
    let old = boat.with_extension("old");
    fs::rename(&boat, &old).unwrap();
    bring();
    put_openvpn(&cable, 'v', &aboard, &boat);
    let vessel = openvpn(&cable.vessel(), &boat);
    until("up with the new certificate", || up(&boat)).await;

    // A vessel whose access is taken has no place any more, though its file is lost: neither of its certificates comes in.
    drop(vessel);
    fs::remove_file(ashore.data().join("fleet/otter-1.ovpn")).unwrap();
    ashore.run(&["fleet", "revoke", "otter-1"]);
    fs::remove_dir_all(shore.join("lutra.ccd")).unwrap();
    put_openvpn(&cable, 's', &from, &shore);
    for folder in [&boat, &old] {
        let before = refused();
        let _vessel = openvpn(&cable.vessel(), folder);
        until("refused for good", || (refused() > before).then_some(())).await;
        assert!(up(folder).is_none(), "{}", log(folder));
    }
    let places = files(&from.join("lutra.ccd"));
    assert_eq!(places.len(), 1);
    assert!(present[1].starts_with("otter-2.") && places[0].0.ends_with(&present[1]));
    assert_eq!(places[0].1, b"ifconfig-push 10.77.0.12 255.255.255.0\n");

    // The server gets another authority and another key for first packets; the boat gets new access by it.
    drop(running);
    fs::remove_file(ashore.data().join("fleet/openvpn.key")).unwrap();
    ashore.apply(&["--new-server-key"]);
    fs::remove_dir_all(shore.join("lutra.ccd")).unwrap();
    put_openvpn(&cable, 's', &from, &shore);
    let _running = openvpn(&cable.shore(), &shore);
    until("OpenVPN up ashore again", || up(&shore)).await;
    let vessel = openvpn(&cable.vessel(), &boat);
    until("not answered", || log(&shore).contains("tls-crypt unwrap").then_some(())).await;
    drop(vessel);
    bring();
    put_openvpn(&cable, 'v', &aboard, &boat);
    let _vessel = openvpn(&cable.vessel(), &boat);
    until("up by the new authority", || up(&boat)).await;
}
