//! Fleet files that are read, and the reports for those that are not.

use super::*;
use proptest::prelude::*;

const EXAMPLE: &str = include_str!("../../../../deploy/fleet.example.toml");

/// A good file, with `old` replaced.
fn with(old: &str, new: &str) -> Vec<String> {
    assert!(EXAMPLE.contains(old), "{old}");
    let problems = Fleet::read(&EXAMPLE.replacen(old, new, 1)).unwrap_err();
    problems.iter().map(ToString::to_string).collect()
}

#[test]
fn the_example_is_the_address_plan_of_the_thesis() {
    let fleet = Fleet::read(EXAMPLE).unwrap();
    let plan: Vec<_> = fleet.vessels.iter().map(|one| (one.name.as_str(), one.imc_address)).collect();
    let expected = [
        ("ntnu-otter-01", 0x2810),
        ("ntnu-otter-02", 0x2811),
        ("ntnu-otter-03", 0x2812),
        ("ntnu-otter-04", 0x2813),
    ];
    assert_eq!(plan, expected);
    assert!(fleet.vessels.iter().all(|vessel| fleet.vpn.network.has_host(vessel.vpn_address)));
    assert_eq!(fleet.link_url(), "ws://10.8.0.1:8080/link");
}

#[test]
fn a_vessel_has_what_is_common_unless_it_says_otherwise() {
    let fleet = Fleet::read(EXAMPLE).unwrap();
    let port = |name: &str| {
        let vessel = fleet.vessel(name).unwrap();
        vessel.devices.iter().find(|(device, _)| *device == Device::Hydrophone).unwrap().1.clone()
    };
    assert_eq!(
        (port("ntnu-otter-01"), port("NTNU-otter-03")),
        ("/dev/lutra/hydrophone".into(), "/dev/ttyAMA0".into())
    );
    let last = fleet.vessel("ntnu-otter-04").unwrap();
    assert_eq!((last.limits.top_speed_mps, last.limits.autonomous_depth_m), (Some(1.5), Some(5.0)));
    let setting =
        Setting { section: "Supervisors.Grounding".into(), key: "Air Draught".into(), value: "1.5".into() };
    assert_eq!(last.settings, [setting]);
}

#[test]
fn a_vessel_has_the_common_ways_or_its_own() {
    let own = "[[vessel.ways]]\nname = \"satellite\"\n";
    let ways =
        "[[common.ways]]\nname = \"4G\"\ninterface = \"wwan0\"\nmetered = true\ndaily_budget_mib = 50\n";
    let text = EXAMPLE.replacen("[common.devices]", &format!("{ways}[common.devices]"), 1);
    let fleet = Fleet::read(&format!("{text}\n{own}")).unwrap();
    let names = |at: usize| fleet.vessels[at].ways.iter().map(|way| &way.name[..]).collect::<Vec<_>>();
    assert_eq!((names(0), names(3)), (vec!["4G"], vec!["satellite"]));
    let expected = Way {
        name: "4G".into(),
        url: None,
        interface: Some("wwan0".into()),
        source_address: None,
        metered: true,
        daily_budget_mib: Some(50),
    };
    assert_eq!(fleet.vessels[0].ways, [expected]);
}

#[test]
fn what_is_wrong_with_a_way_is_told_with_its_line() {
    let way = |keys: &str| {
        let text = format!("{EXAMPLE}[[vessel.ways]]\nname = \"4G\"\n{keys}\n");
        let problems = Fleet::read(&text).unwrap_err();
        let line = EXAMPLE.lines().count() + 3;
        assert!(problems.iter().all(|one| one.line == line && !one.remedy.is_empty()), "{problems:#?}");
        problems.iter().map(ToString::to_string).collect::<Vec<_>>().concat()
    };
    for (keys, wrong) in [
        ("interface = \"an-interface-too-long\"", "cannot be a network interface"),
        ("interface = \"wwan0 \"", "cannot be a network interface"),
        ("source_address = \"wwan0\"", "is not an IP address"),
        ("daily_budget_mib = 50", "only a way that is metered"),
        ("daily_budget_mib = 0", "0 cannot be"),
        ("metred = true", "did you mean `metered`"),
        ("url = \"https://lutra.example.org\"", "not an address of the vessel link"),
        ("url = \"ws:///link\"", "not an address of the vessel link"),
        ("url = \"ws://lutra.example.org:99999/link\"", "not an address of the vessel link"),
        ("url = \"wss://lutra.example.org/link\"", "encrypted = true"),
        ("metered = 1", "true or false"),
    ] {
        let told = way(keys);
        assert!(told.contains(wrong) && told.contains("vessel ntnu-otter-04: way 1"), "{told}");
    }
    let many = "[[vessel.ways]]\nname = \"4G\"\n".repeat(9);
    let problems = Fleet::read(&format!("{EXAMPLE}{many}")).unwrap_err();
    let all: Vec<String> = problems.iter().map(ToString::to_string).collect();
    assert!(all[0].contains("two are called") && all.last().unwrap().contains("more than 8 ways"), "{all:?}");
    let alike = "[[vessel.ways]]\nname = \"4G\"\n[[vessel.ways]]\nname = \" 4G \"\n";
    let problems = Fleet::read(&format!("{EXAMPLE}{alike}")).unwrap_err();
    assert!(problems.iter().any(|one| one.to_string().contains("two are called \"4G\"")), "{problems:#?}");
    for taken in ["GPS", " Receiver ", "Lutra Link"] {
        let problems = Fleet::read(&format!("{EXAMPLE}[[vessel.ways]]\nname = \"{taken}\"\n")).unwrap_err();
        assert_eq!((problems.len(), problems[0].line), (1, EXAMPLE.lines().count() + 2));
        let text = problems[0].to_string();
        assert!(text.contains("another task aboard is called") && text.contains(taken.trim()), "{text}");
    }
    let nameless =
        Fleet::read(&format!("{EXAMPLE}[[vessel.ways]]\nname = \"{}\"\n[[vessel.ways]]\n", "x".repeat(33)));
    let all: Vec<String> = nameless.unwrap_err().iter().map(ToString::to_string).collect();
    assert!(all[0].contains("at most 32 bytes") && all[1].contains("`name` is missing"), "{all:?}");
}

#[test]
fn every_problem_is_told_at_once_with_its_line() {
    let text = "\
[server]
public_name = \"https://boats.example.org\"
link_prot = 8080
doors = [\"udp/6001\", \"udp/6001\", \"6001\"]
[vpn]
network = \"10.8.0.0/24\"
server_address = \"10.9.0.1\"
port = \"51820\"
[[vessel]]
name = \"otter 1\"
imc_address = 0x4F00
vpn_address = \"10.8.0.11\"
[[vessel]]
name = \"otter-2\"
imc_address = 0x2811
vpn_address = \"10.8.1.12\"
[[vessel]]
name = \"Otter-2\"
imc_address = 0x2811
vpn_address = \"10.8.1.12\"
limits = { top_speed_mps = 99, navigable_depth_m = 6, autonomous_depth_m = 5 }
";
    let problems = Fleet::read(text).unwrap_err();
    let lines: Vec<usize> = problems.iter().map(|problem| problem.line).collect();
    assert_eq!(lines, [2, 3, 4, 4, 7, 8, 10, 11, 16, 18, 19, 20, 20, 21, 21], "{problems:#?}");
    assert!(problems.iter().all(|problem| !problem.remedy.is_empty()), "{problems:#?}");
    assert!(problems[1].remedy.contains("`link_port`"), "{}", problems[1]);
}

#[test]
fn each_mistake_is_told_in_words() {
    for (old, new, told) in [
        ("imc_address = 0x2811", "imc_address = 0x2810", "0x2810 is ntnu-otter-01's"),
        ("10.8.0.12", "10.8.0.11", "10.8.0.11 is ntnu-otter-01's"),
        ("10.8.0.12", "10.8.0.1", "10.8.0.1 is the server's"),
        ("10.8.0.12", "10.8.0.255", "not in 10.8.0.0/24"),
        ("imc_address = 0x2811", "imc_address = 0xFFFF", "not a vessel's address"),
        ("imc_address = 0x2811", "imc_address = -1", "-1 cannot be"),
        ("imc_address = 0x2811", "", "`imc_address` is missing"),
        ("\"ntnu-otter-02\"", "\"../etc\"", "cannot be a vessel's name"),
        ("\"can0\"", "\"/dev/lutra/compass\"", "compass's already"),
        ("\"can0\"", "\"can0 # one\"", "cannot stand in an .ini file"),
        ("hull = \"ASV\"", "hul = \"ASV\"", "did you mean `hull`?"),
        ("hull = \"ASV\"", "hull = \"ASV\"\nhull = \"B\"", "duplicate key"),
        ("\"Hardware\"", "\"Hardwear\"", "not a profile"),
        ("\"Air Draught\" = 1.5", "\"Air Draught\" = [1]", "not a text, a number"),
        ("\"Air Draught\" = 1.5", "\"Air\\nDraught\" = 1", "cannot stand in an .ini file"),
        ("encrypted = false", "encrypted = 0", "write true or false"),
    ] {
        let problems = with(old, new);
        assert!(problems.iter().any(|problem| problem.contains(told)), "{new}: {problems:#?}");
    }
}

#[test]
fn the_vpn_is_wireguard_unless_the_file_says_openvpn() {
    let silent = EXAMPLE.replace("kind = \"wireguard\"", "").replace("port = 51820", "");
    let fleet = Fleet::read(&silent).unwrap();
    assert_eq!((fleet.vpn.kind, fleet.vpn.port), (VpnKind::WireGuard, 51_820));
    let openvpn = EXAMPLE.replace("\"wireguard\"", "\"openvpn\"");
    assert_eq!(Fleet::read(&openvpn).unwrap().vpn.port, 51_820, "the file says which port");
    let usual = openvpn.replace("port = 51820", "");
    let vpn = Fleet::read(&usual).unwrap().vpn;
    assert_eq!(
        (vpn.kind, vpn.port, vpn.network.mask()),
        (VpnKind::OpenVpn, 1_194, [255, 255, 255, 0].into())
    );
    // All that is wrong is told at once, each with its line.
    let wrong = openvpn.replace("\"openvpn\"", "\"ipsec\"").replace("10.8.0.12", "10.9.0.12");
    let problems = Fleet::read(&wrong).unwrap_err();
    let line = |what: &str| wrong.lines().position(|line| line.contains(what)).unwrap() + 1;
    let told: Vec<_> = problems.iter().map(|one| (one.line, one.text.as_str())).collect();
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(
        told[0].0 == line("kind = \"ipsec\"") && told[0].1.contains("is not a VPN that Lutra sets up"),
        "{told:?}"
    );
    assert_eq!(told[1].0, line("10.9.0.12"));
}

#[test]
fn what_is_absent_is_told_once_each() {
    let problems = Fleet::read("").unwrap_err();
    let told: Vec<String> = problems.iter().map(ToString::to_string).collect();
    assert_eq!(told.len(), 3, "{told:?}");
}

proptest! {
    /// Damaged files are refused in words or are still whole; nothing panics.
    #[test]
    fn damaged_files_are_read_or_refused(at in 0..EXAMPLE.len(), insert in ".{0,8}", cut in 0..EXAMPLE.len()) {
        let split = (0..=at).rev().find(|at| EXAMPLE.is_char_boundary(*at)).unwrap();
        let (before, after) = EXAMPLE.split_at(split);
        for text in [format!("{before}{insert}{after}"), EXAMPLE.chars().take(cut).collect()] {
            if let Err(problems) = Fleet::read(&text) {
                prop_assert!(!problems.is_empty());
            }
        }
    }
}
