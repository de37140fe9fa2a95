//! Commands of a person or a test to the running simulated devices: one line each.

use anyhow::{Context as _, bail};
use std::str::FromStr;

/// A simulated device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// The compass.
    Gnss,
    /// The motors' card behind its adapter.
    Motors,
    /// The receiver of fish tags.
    Hydrophone,
}

impl Kind {
    /// All, in the order of their lines.
    pub(super) const ALL: [Self; 3] = [Self::Gnss, Self::Motors, Self::Hydrophone];

    /// Its name on lines and links.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Gnss => "gnss",
            Self::Motors => "motors",
            Self::Hydrophone => "hydrophone",
        }
    }
}

/// The fault, or its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fault {
    /// The cable is pulled.
    Unplug,
    /// The cable is put in again.
    Plug,
    /// The device is silent; the motor card still obeys.
    Silence,
    /// It sends noise instead of data, at the full speed of its line.
    Babble,
    /// It sends invalid values: fields that are not numbers, or far out of range.
    Nonsense,
    /// The motor card does not switch power channels any more.
    Refuse,
    /// The CAN adapter of the motors, or the compass, loses its power for a moment, without being unplugged: the adapter
    /// has left the bus, the compass has lost unsaved settings.
    Restart,
    /// The end of all faults of the device.
    Mend,
    /// Not a fault: prints the instants at which the hydrophone's clock was set.
    Report,
}

/// A parsed line: fault and device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Order {
    /// The fault, or its end.
    pub(super) fault: Fault,
    /// The device.
    pub(super) kind: Kind,
}

impl FromStr for Order {
    type Err = anyhow::Error;

    fn from_str(line: &str) -> anyhow::Result<Self> {
        let wanted = || {
            format!(
                "`{line}`: write unplug, plug, silence, babble, nonsense or mend, and gnss, motors or hydrophone; or refuse \
                 motors, restart motors, restart gnss, report hydrophone"
            )
        };
        let (word, name) = line.trim().split_once(' ').with_context(wanted)?;
        let fault = match word {
            "unplug" => Fault::Unplug,
            "plug" => Fault::Plug,
            "silence" => Fault::Silence,
            "babble" => Fault::Babble,
            "nonsense" => Fault::Nonsense,
            "refuse" => Fault::Refuse,
            "restart" => Fault::Restart,
            "report" => Fault::Report,
            "mend" => Fault::Mend,
            _ => bail!(wanted()),
        };
        let kind = Kind::ALL.into_iter().find(|kind| kind.name() == name.trim()).with_context(wanted)?;
        let has_it = match fault {
            Fault::Refuse => kind == Kind::Motors,
            Fault::Restart => kind != Kind::Hydrophone,
            Fault::Report => kind == Kind::Hydrophone,
            _ => true,
        };
        if !has_it {
            bail!(wanted());
        }
        Ok(Self { fault, kind })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_and_others_refused_with_what_may_be_written() {
        let order: Order = "silence motors\n".parse().unwrap();
        assert_eq!(order, Order { fault: Fault::Silence, kind: Kind::Motors });
        for line in ["restart motors", "restart gnss", "report hydrophone"] {
            assert!(line.parse::<Order>().is_ok(), "{line}");
        }
        for line in [
            "silence",
            "sink motors",
            "plug radar",
            "",
            "restart hydrophone",
            "refuse hydrophone",
            "report motors",
        ] {
            let refused = line.parse::<Order>().unwrap_err().to_string();
            assert!(refused.contains("unplug, plug, silence"), "{refused}");
        }
    }
}
