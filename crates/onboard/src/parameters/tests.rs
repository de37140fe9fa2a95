use super::*;
use imc::Address;

fn setups() -> [Settings; 2] {
    let force = Settings::otter("test", Address(0x2810));
    let rpm = Settings { control: control::CourseSpeedConfig::fossen_rpm(), ..force.clone() };
    [force, rpm]
}

fn named(name: &str) -> Parameter {
    all().into_iter().find(|parameter| parameter.name == name).unwrap()
}

#[test]
fn every_value_in_use_is_allowed_and_returns_as_it_was() {
    for settings in setups() {
        for parameter in all() {
            let Some(text) = parameter.get(&settings) else { continue };
            let mut again = settings.clone();
            assert_eq!(parameter.set(&mut again, &text), Ok(()), "{}", parameter.name);
            assert_eq!(parameter.get(&again), Some(text), "{}", parameter.name);
        }
    }
}

#[test]
fn what_the_schema_allows_every_controller_takes() {
    use config::Kind;
    for settings in setups() {
        for parameter in all().into_iter().filter(|parameter| parameter.get(&settings).is_some()) {
            let texts = match parameter.spec.kind {
                Kind::Float { min, max, .. } => [min, max].map(|end| end.to_string()).to_vec(),
                Kind::Floats { min, max, .. } => {
                    [min, max].map(|end| format!("{end}, {end}, {end}")).to_vec()
                }
                Kind::Choice { options, .. } => options.iter().map(|word| (*word).to_owned()).collect(),
                kind => panic!("{kind:?}"),
            };
            let ordered = parameter.name.ends_with(" Level");
            for text in texts {
                let taken = parameter.set(&mut settings.clone(), &text);
                assert!(taken.is_ok() || ordered, "{} = {text}: {taken:?}", parameter.name);
            }
        }
    }
}

#[test]
fn every_parameter_stands_in_the_schema_of_its_sections() {
    for parameter in all() {
        for home in parameter.homes {
            let spec = home.params().find(|spec| spec.name == parameter.name);
            let spec = spec.unwrap_or_else(|| panic!("{} in {}", parameter.name, home.name()));
            let bounds = |kind| match kind {
                config::Kind::Float { min, max, .. } | config::Kind::Floats { min, max, .. } => {
                    (min, max, &[][..])
                }
                config::Kind::Choice { options, .. } => (0.0, 0.0, options),
                kind => panic!("{kind:?}"),
            };
            assert_eq!(bounds(spec.kind), bounds(parameter.spec.kind), "{}", parameter.name);
        }
    }
}

#[test]
fn refuses_what_is_no_number_or_out_of_range() {
    let [mut settings, _] = setups();
    let before = settings.clone();
    let lookahead = named("ILOS Lookahead Distance");
    for bad in ["", "x", "NaN", "inf", "0", "51", "3 m"] {
        assert!(lookahead.set(&mut settings, bad).is_err(), "{bad}");
    }
    let yaw = named("Yaw PID Gains");
    for bad in ["1, 2", "1, 2, x", "1, 2, 3, 4", "-1, 0, 0"] {
        assert!(yaw.set(&mut settings, bad).is_err(), "{bad}");
    }
    assert!(named("Reserve Level").set(&mut settings, "40").is_err(), "above the warning");
    assert_eq!(settings, before);
    lookahead.set(&mut settings, " 12.5 ").unwrap();
    assert_eq!(lookahead.get(&settings).unwrap(), "12.5");
}

#[test]
fn what_a_vessel_told_becomes_settings_and_nonsense_changes_nothing() {
    let [mut settings, _] = setups();
    let usual = settings.clone();
    let mut take = |entity, told: &[(&'static str, &'static str)]| {
        take_told(&mut settings, entity, told.iter().copied())
    };
    let nonsense = [
        ("Autonomous Depth", "x"),
        ("Autonomous Depth", "1e9"),
        ("No Such Thing", "1"),
        ("Chart Trust", "none"),
        ("Loiter -- Minimum Radius", "33"),
    ];
    assert_eq!(take(Entity::Grounding, &nonsense).len(), 0);
    let good = [("Autonomous Depth", "7.5"), ("Air Draught", "0"), ("Chart Trust", "all errors")];
    assert_eq!(take(Entity::Grounding, &good).len(), 3);
    assert_eq!(take(Entity::Maneuver, &[("Loiter -- Minimum Radius", "33")]).len(), 1);
    let limits = settings.guard_limits();
    assert_eq!((limits.autonomous_m, limits.air_draught_m), (7.5, None));
    assert_eq!(limits.trust, ChartTrust::AllErrors(ChartTrust::STANDARD));
    assert_eq!(limits.least_loiter_m.to_bits(), 33.0_f64.to_bits(), "the least circle that is sailed counts");
    assert_ne!(settings, usual);
    assert_eq!(limits.entry, EntryRules::default());
    for word in ["refuse all", "warn", "ignore", "refuse prohibited"] {
        assert_eq!(
            take_told(&mut settings, Entity::Grounding, [("Restricted Areas", word)].into_iter()).len(),
            1
        );
        assert_eq!(named("Restricted Areas").get(&settings).unwrap(), word);
    }
    assert_eq!(
        settings.guard_limits().entry,
        EntryRules::default(),
        "the word that is usual is the rule that is usual"
    );
}

#[test]
fn no_safety_limit_has_a_value_that_switches_it_off() {
    let [mut settings, _] = setups();
    settings.watch.limits.max_speed_mps = Some(3.0);
    for off in ["-1", "0", "1000"] {
        assert!(named("Maximum Speed").set(&mut settings, off).is_err(), "{off}");
    }
    for name in ["Maximum Speed", "Warning Level", "Reserve Level", "Error Level", "Maximum HDOP"] {
        assert_eq!(named(name).access, Access::FileOnly, "{name}");
    }
}
