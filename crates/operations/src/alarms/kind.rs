//! The kinds of alarm: how urgent, how soon, and what each means to the operator.

use std::time::Duration;

/// How urgent an alarm is (MSC.302(87)).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Priority {
    /// For information; needs no acknowledgement.
    Caution,
    /// To be looked at soon.
    Warning,
    /// To be acted upon now.
    Alarm,
    /// Danger to life, vessel or sea.
    Emergency,
}

impl Priority {
    /// All, the least urgent first.
    pub const ALL: [Self; 4] = [Self::Caution, Self::Warning, Self::Alarm, Self::Emergency];

    /// The word for people and machines.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Caution => "caution",
            Self::Warning => "warning",
            Self::Alarm => "alarm",
            Self::Emergency => "emergency",
        }
    }

    /// The priority of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|one| one.name() == name)
    }

    /// How often it sounds until it is acknowledged; `None` for silent ones.
    pub const fn repeats(self) -> Option<Duration> {
        match self {
            Self::Caution => None,
            Self::Warning => Some(Duration::from_mins(5)),
            Self::Alarm => Some(Duration::from_secs(30)),
            Self::Emergency => Some(Duration::from_secs(5)),
        }
    }
}

/// The kinds of trouble.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// The grounding supervisor sees danger.
    Grounding,
    /// Nothing comes from the vessel.
    NotHeard,
    /// Nothing came from a vessel that has a link since the server started.
    NeverHeard,
    /// Another peer sends with the address of a vessel that has a link.
    OtherSource,
    /// The vessel does not know where it is.
    Position,
    /// The vessel hears no console, though the shore hears the vessel.
    NoConsole,
    /// Little charge is left.
    Battery,
    /// A motor does not work.
    Motor,
    /// Nothing comes from the hydrophone.
    Hydrophone,
    /// The vessel's clock differs from the shore's.
    Clock,
    /// The vessel sails by another sea chart than the shore's.
    Chart,
    /// Another part of the vessel reports trouble.
    Part,
    /// The vessel wrote an error into its log book.
    LogBook,
    /// The server cannot record.
    Recording,
    /// The history lags behind what is recorded.
    History,
    /// The server's disk is nearly full.
    Disk,
    /// The server's certificate ends, or a new one cannot be used.
    Certificate,
    /// The sea chart does not hold what people closed.
    NoGoAreas,
    /// There are more alarms than are kept.
    TooMany,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 19] = [
        Self::Grounding,
        Self::NotHeard,
        Self::NeverHeard,
        Self::OtherSource,
        Self::Position,
        Self::NoConsole,
        Self::Battery,
        Self::Motor,
        Self::Hydrophone,
        Self::Clock,
        Self::Chart,
        Self::Part,
        Self::LogBook,
        Self::Recording,
        Self::History,
        Self::Disk,
        Self::Certificate,
        Self::NoGoAreas,
        Self::TooMany,
    ];

    /// A stable word for machines.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Grounding => "grounding",
            Self::NotHeard => "not_heard",
            Self::NeverHeard => "never_heard",
            Self::OtherSource => "other_source",
            Self::Position => "position",
            Self::NoConsole => "no_console",
            Self::Battery => "battery",
            Self::Motor => "motor",
            Self::Hydrophone => "hydrophone",
            Self::Clock => "clock",
            Self::Chart => "chart",
            Self::Part => "part",
            Self::LogBook => "log_book",
            Self::Recording => "recording",
            Self::History => "history",
            Self::Disk => "disk",
            Self::Certificate => "certificate",
            Self::NoGoAreas => "no_go_areas",
            Self::TooMany => "too_many",
        }
    }

    /// The kind of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|one| one.name() == name)
    }

    /// Its cause, consequence and remedy.
    #[expect(clippy::too_many_lines, reason = "a table, an entry for each kind")]
    pub const fn advice(self) -> Advice {
        let (cause, consequence, action) = match self {
            Self::Grounding => (
                "The chart has shallow water, land or a danger where the vessel is or heads.",
                "It may run aground. Under manual control nobody else stops it in time.",
                "Stop it, look at the chart, and steer for deep water.",
            ),
            Self::NotHeard => (
                "The vessel has no radio or network contact, its computer is down, or it was switched off.",
                "What is shown of it is old and orders do not arrive. It goes on by itself as its supervisor for \
                 lost communications is set.",
                "Read on the vessel's page what it will do and when; restore the link, or go to its last position.",
            ),
            Self::NeverHeard => (
                "It came in by its link before; now it is switched off, out of reach, or refused.",
                "Where it is and what it does is not known here; what the history has of it is older.",
                "Look at Admin, Connections, and at the vessel. If it is laid up, revoke its link token or forget it \
                 under Admin, Vessels.",
            ),
            Self::OtherSource => (
                "The vessel has a link with a token; by a transport without passwords another program, another vessel with the \
                 same IMC address, or the vessel itself by a second way sends packets in its name.",
                "They are refused: neither shown, nor recorded, nor passed on, and no order goes there.",
                "Look at the address above. If it is the vessel itself, switch that way off aboard or name the transport \
                 in transports.trusted; if not, stop it, or narrow the transport by its allow list.",
            ),
            Self::Position => (
                "The satellite compass gives no good position, or navigation does not run.",
                "The vessel cannot keep its plan; where it is shown is not where it is.",
                "Stop it or steer by sight; look at the parts of compass and navigation.",
            ),
            Self::NoConsole => (
                "The way from the shore to the vessel is broken, while the way back works.",
                "Orders do not arrive, and the vessel does what it is set to do without communications.",
                "Look at the transports and the link; read on the vessel's page what it will do and when.",
            ),
            Self::Battery => (
                "The batteries are nearly used up, or one of them does not report.",
                "The vessel may not come home by itself.",
                "Bring it home or stop it where it can be fetched.",
            ),
            Self::Motor => (
                "A motor reports an error or does not report at all.",
                "With one motor the vessel hardly steers; with none it drifts.",
                "Stop it; switch the motor off and on, or fetch the vessel.",
            ),
            Self::Hydrophone => (
                "The receiver is off, its cable is loose, or its serial port is wrong.",
                "No fish are heard meanwhile.",
                "Look at the receiver's part and at its cable.",
            ),
            Self::Clock => (
                "The vessel's computer does not get the time, or was set by hand.",
                "Times of what it records are wrong by as much.",
                "Set its clock before the survey goes on; note the offset.",
            ),
            Self::Chart => (
                "The chart set ashore changed and is still on its way, or the vessel could not take it.",
                "What the shore takes for deep water the vessel may refuse, and the other way round.",
                "Wait until it is aboard; if it says why it is not, do something about that, or carry it aboard \
                 with lutra-server chart sync.",
            ),
            Self::Part => (
                "The part says so itself; its own words are above.",
                "What needs the part does not work.",
                "Look at the vessel's entities and its log book.",
            ),
            Self::LogBook => (
                "Something aboard failed once.",
                "It may happen again.",
                "Read the log book around that time.",
            ),
            Self::Recording => (
                "The disk is full or broken.",
                "What happens now is not recorded. Vessels on the link keep their records for a while.",
                "Make room on the server's disk, or replace it.",
            ),
            Self::History => (
                "The tables made from the records cannot be brought up to date.",
                "Plots and tables of the past are incomplete. Nothing is lost.",
                "Look at the reason; lutra-server doctor tells more.",
            ),
            Self::Disk => (
                "Recordings and charts fill the server's disk.",
                "When it is full nothing is recorded any more.",
                "Make room, or remove old history with lutra-server prune.",
            ),
            Self::Certificate => (
                "The server's certificate ends soon or has ended, or a new one in its place cannot be used.",
                "After its end browsers warn of the server and vessels do not come in by their links.",
                "One that Lutra made: lutra-server tls renew. One from elsewhere: renew it there. The server takes \
                 the new files by itself, without a restart.",
            ),
            Self::NoGoAreas => (
                "The chart set is missing, damaged or held by another program, or an area cannot be read.",
                "No plan passes and no route is planned. Vessels go on by the chart that they hold: areas that were closed \
                 since then do not stop them.",
                "Look at Plans, No-go areas for the reason. Stop a vessel that sails towards an area that was closed lately.",
            ),
            Self::TooMany => (
                "Many parts of many vessels report trouble at once.",
                "Less urgent alarms are not listed.",
                "Deal with the most urgent ones; the others appear when there is room.",
            ),
        };
        Advice { cause, consequence, action }
    }

    /// How long the trouble must last before it is one.
    pub(crate) const fn delay(self) -> Duration {
        Duration::from_secs(match self {
            Self::Grounding
            | Self::LogBook
            | Self::OtherSource
            | Self::Recording
            | Self::Certificate
            | Self::TooMany
            | Self::NotHeard => 0,
            Self::Motor => 2,
            Self::Position | Self::Part => 3,
            Self::Battery | Self::NoConsole => 5,
            Self::Clock | Self::Hydrophone | Self::History | Self::Disk | Self::NoGoAreas => 10,
            Self::Chart | Self::NeverHeard => 60,
        })
    }

    /// How long it must be gone before it counts as gone.
    pub(crate) const fn rest(self) -> Duration {
        Duration::from_secs(match self {
            Self::NotHeard | Self::Recording => 3,
            Self::Battery | Self::Disk | Self::Clock => 30,
            _ => 5,
        })
    }

    /// Whether it is reported also for a silent vessel.
    pub(crate) const fn outlives_silence(self) -> bool {
        matches!(self, Self::NotHeard | Self::OtherSource)
    }

    /// Whether a warning that is not acknowledged becomes an alarm.
    pub(crate) const fn escalates(self) -> bool {
        matches!(
            self,
            Self::NotHeard | Self::Position | Self::NoConsole | Self::Battery | Self::Motor | Self::Grounding
        )
    }
}

/// The meaning of an alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Advice {
    /// Why it comes.
    pub cause: &'static str,
    /// What follows if no one acts on it.
    pub consequence: &'static str,
    /// What to do.
    pub action: &'static str,
}
