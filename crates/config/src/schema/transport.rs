//! How messages leave the vessel: datagrams, streams, announcements, the log.

#![expect(missing_docs, reason = "each parameter carries its documentation as a value")]

use crate::schema::common::OF_EVERY_TASK;
use crate::spec::{
    Param, ParamSpec, SectionSpec, Unit, address, choice, flag, float, int, pairs, rates, text, texts, unused,
};

const ON_THE_SURFACE: &str = "Lutra does not simulate radio range here";

pub const ANNOUNCE_SERVICE: Param<bool> =
    flag("Announce Service", true).doc("Whether the announcement names this transport.");
pub const MESSAGES: Param<Vec<String>> =
    texts("Transports", &[]).doc("Messages that are carried, by their IMC names; empty for all.");
pub const RATES: Param<Vec<(String, f64)>> = rates("Rate Limiters", &[], Unit::Hertz)
    .doc("Greatest rate of a message for each entity, as Message:Hz.");
pub const FILTERS: Param<Vec<(String, String)>> =
    pairs("Filtered Entities").doc("Entities that may send a message, as Message:Entity+Entity.");

const OF_EVERY_TRANSPORT: &[ParamSpec] = &[ANNOUNCE_SERVICE.spec, MESSAGES.spec, RATES.spec, FILTERS.spec];

/// Messages that go to consoles by default.
const TO_CONSOLES: &[&str] = &[
    "Abort",
    "ControlLoops",
    "ControlParcel",
    "CpuUsage",
    "Current",
    "DesiredHeading",
    "DesiredPath",
    "DesiredSpeed",
    "EntityList",
    "EntityMonitoringState",
    "EntityParameters",
    "EntityState",
    "EstimatedState",
    "EulerAngles",
    "Event",
    "FollowRefState",
    "FuelLevel",
    "GpsFix",
    "Heartbeat",
    "LogBookEntry",
    "LoggingControl",
    "ManeuverControlState",
    "PathControlState",
    "PlanControl",
    "PlanControlState",
    "PlanDB",
    "PlanSpecification",
    "PowerChannelState",
    "RemoteActionsRequest",
    "Rpm",
    "SetThrusterActuation",
    "SimulatedState",
    "StorageUsage",
    "TBRFishTag",
    "TBRSensor",
    "Temperature",
    "VehicleCommand",
    "VehicleMedium",
    "VehicleState",
    "Voltage",
];

pub mod udp {
    use super::{
        ANNOUNCE_SERVICE, FILTERS, OF_EVERY_TASK, ON_THE_SURFACE, Param, SectionSpec, TO_CONSOLES, Unit,
        flag, float, int, pairs, rates, texts, unused,
    };

    pub const PORT: Param<i64> = int("Local Port", 6002, Unit::None)
        .within(1, 65_535)
        .doc("Port that is listened on; the next five are tried when it is taken.");
    pub const MESSAGES: Param<Vec<String>> =
        texts("Transports", TO_CONSOLES).doc("Messages that are carried, by their IMC names.");
    pub const RATES: Param<Vec<(String, f64)>> = rates(
        "Rate Limiters",
        &[
            ("CpuUsage", 0.2),
            ("EntityState", 1.0),
            ("EstimatedState", 10.0),
            ("FuelLevel", 0.1),
            ("SimulatedState", 0.5),
            ("StorageUsage", 0.05),
            ("Temperature", 1.0),
            ("Voltage", 0.1),
        ],
        Unit::Hertz,
    )
    .doc("Greatest rate of a message for each entity, as Message:Hz.");
    pub const CONTACT_TIMEOUT: Param<f64> = float("Contact Timeout", 30.0, Unit::Second)
        .within(1.0, 3600.0)
        .doc("A node that is silent for so long is sent nothing more.");
    pub const CONTACT_REFRESH: Param<f64> = float("Contact Refresh Periodicity", 5.0, Unit::Second)
        .within(0.1, 600.0)
        .doc("How often the nodes that are sent to are looked through.");
    pub const STATIC_DESTINATIONS: Param<Vec<(String, String)>> =
        pairs("Static Destinations").doc("Nodes that are always sent to, as address:port.");
    pub const DYNAMIC_NODES: Param<bool> =
        flag("Dynamic Nodes", true).doc("Whether nodes that announce themselves are sent to.");
    pub const LOCAL_ONLY: Param<bool> =
        flag("Local Messages Only", false).doc("Whether only messages of this vessel are carried.");
    pub const PRINT_IN: Param<bool> =
        flag("Print Incoming Messages", false).doc("Whether received messages are logged.");
    pub const PRINT_OUT: Param<bool> =
        flag("Print Outgoing Messages", false).doc("Whether sent messages are logged.");

    pub static UDP: SectionSpec = SectionSpec::task(&["Transports.UDP"], "UDP", "Always")
        .doc("Carries messages in datagrams.")
        .groups(&[
            OF_EVERY_TASK,
            &[
                PORT.spec,
                ANNOUNCE_SERVICE.spec,
                CONTACT_TIMEOUT.spec,
                CONTACT_REFRESH.spec,
                DYNAMIC_NODES.spec,
                STATIC_DESTINATIONS.spec,
                LOCAL_ONLY.spec,
                PRINT_IN.spec,
                PRINT_OUT.spec,
                MESSAGES.spec,
                RATES.spec,
                FILTERS.spec,
                unused("Communication Range", ON_THE_SURFACE),
                unused("Underwater Communications", ON_THE_SURFACE),
                unused("Always Transmitted Messages", ON_THE_SURFACE),
            ],
        ]);
}

pub mod tcp {
    use super::{OF_EVERY_TASK, OF_EVERY_TRANSPORT, Param, SectionSpec, Unit, int, text};

    pub const PORT: Param<i64> =
        int("Port", 7001, Unit::None).within(1, 65_535).doc("Port that is listened on.");

    pub static SERVER: SectionSpec = SectionSpec::task(&["Transports.TCP.Server"], "TCP Server", "Always")
        .doc("Carries messages to everyone who connects.")
        .groups(&[OF_EVERY_TASK, OF_EVERY_TRANSPORT, &[PORT.spec]]);

    pub const SERVER_ADDRESS: Param<String> =
        text("Server - Address", "127.0.0.1").doc("Host that is connected to.");
    pub const SERVER_PORT: Param<i64> =
        int("Server - Port", 7001, Unit::None).within(1, 65_535).doc("Port that is connected to.");

    pub static CLIENT: SectionSpec = SectionSpec::task(&["Transports.TCP.Client"], "TCP Client", "Never")
        .doc("Connects to another node and carries messages to it.")
        .groups(&[OF_EVERY_TASK, OF_EVERY_TRANSPORT, &[SERVER_ADDRESS.spec, SERVER_PORT.spec]]);
}

pub mod announce {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, address, choice, flag, float, texts, unused};
    use crate::spec::ints;

    pub const PERIOD: Param<f64> = float("Announcement Periodicity", 10.0, Unit::Second)
        .within(1.0, 600.0)
        .doc("How often the vessel announces itself.");
    pub const LOOPBACK: Param<bool> =
        flag("Enable Loopback", true).doc("Whether it is announced to this computer.");
    pub const MULTICAST: Param<bool> =
        flag("Enable Multicast", true).doc("Whether it is announced to the multicast group.");
    pub const BROADCAST: Param<bool> =
        flag("Enable Broadcast", true).doc("Whether it is announced to everyone on the network.");
    pub const GROUP: Param<std::net::Ipv4Addr> =
        address("Multicast Address", [224, 0, 75, 69]).doc("The multicast group.");
    pub const PORTS: Param<Vec<i64>> = ints("Ports", &[30_100, 30_101, 30_102, 30_103, 30_104], Unit::None)
        .within(1, 65_535)
        .doc("Ports that are announced to; the first free one is listened on.");
    pub const IGNORED_INTERFACES: Param<Vec<String>> =
        texts("Ignored Interfaces", &[]).doc("Network interfaces that are not announced on.");
    pub const SYSTEM_TYPE: Param<&str> = choice(
        "System Type",
        "USV",
        &["CCU", "HUMANSENSOR", "UUV", "USV", "UAV", "UGV", "STATICSENSOR", "MOBILESENSOR", "WSN"],
    )
    .doc("What the vessel is.");

    pub static ANNOUNCE: SectionSpec = SectionSpec::task(&["Transports.Announce"], "Announce", "Always")
        .doc("Tells the network that the vessel is there, and hears others.")
        .groups(&[
            OF_EVERY_TASK,
            &[
                PERIOD.spec,
                LOOPBACK.spec,
                MULTICAST.spec,
                BROADCAST.spec,
                GROUP.spec,
                PORTS.spec,
                IGNORED_INTERFACES.spec,
                SYSTEM_TYPE.spec,
                unused("Print Outgoing Messages", "Lutra's log level shows them"),
            ],
        ]);
}

pub mod logging {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, choice, flag, float, int, texts};

    pub const FLUSH: Param<f64> = float("Flush Interval", 5.0, Unit::Second)
        .within(0.1, 600.0)
        .doc("Data is on the disk after this time at the latest.");
    pub const COMPRESSION: Param<&str> =
        choice("LSF Compression Method", "gzip", &["none", "gzip"]).doc("How the log is compressed.");
    pub const VOLUME_SIZE: Param<i64> = int("LSF Volume Size", 0, Unit::Mebibyte)
        .within(0, 1 << 20)
        .doc("A new log is begun when the file reaches this size; 0 never does.");
    pub const FOLDERS: Param<Vec<String>> = texts("LSF Volume Directories", &[])
        .doc("Folders that are used one after the other as disks fill; empty for the agent's log folder.");
    pub const MESSAGES: Param<Vec<String>> =
        texts("Transports", &[]).doc("Messages that are logged, by their IMC names; empty for all.");
    pub const REMOVE_OLDEST: Param<bool> = flag("Remove Oldest Logs", false)
        .doc("Lutra: whether the oldest closed logs are removed when the disk is nearly full.");
    pub const KEEP_FREE: Param<i64> = int("Minimum Free Space", 500, Unit::Mebibyte)
        .within(0, 1 << 30)
        .doc("Lutra: free space below which that happens.");

    pub static LOGGING: SectionSpec = SectionSpec::task(&["Transports.Logging"], "Logger", "Always")
        .doc("Writes the vessel's messages to disk.")
        .groups(&[
            OF_EVERY_TASK,
            &[
                FLUSH.spec,
                COMPRESSION.spec,
                VOLUME_SIZE.spec,
                FOLDERS.spec,
                REMOVE_OLDEST.spec,
                KEEP_FREE.spec,
                MESSAGES.spec,
            ],
        ]);
}

pub mod log_book {
    use super::{OF_EVERY_TASK, SectionSpec};

    pub static LOG_BOOK: SectionSpec = SectionSpec::task(&["Transports.LogBook"], "Log Book", "Always")
        .doc("Answers questions about past events.")
        .groups(&[OF_EVERY_TASK]);
}

pub mod lutra {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, flag, float, int, text, texts};

    pub const URL: Param<String> = text("URL", "ws://127.0.0.1:8080/link")
        .doc("Lutra: where the server's transport for vessels is; wss:// needs a certificate authority.");
    pub const TOKEN_FILE: Param<String> = text("Token File", "lutra.token")
        .doc("Lutra: file with the vessel's token, beside this one unless it has a path of its own.");
    pub const AUTHORITY: Param<String> = text("Certificate Authority", "")
        .doc("Lutra: file with the certificates that the server's is checked by, for wss:// only.");
    pub const KEPT_LONGEST: Param<Vec<String>> = texts(
        "Kept Longest",
        &[
            "TBRFishTag",
            "TBRSensor",
            "DevDataText",
            "Event",
            "LogBookEntry",
            "PlanControl",
            "PlanDB",
            "PlanSpecification",
            "VehicleCommand",
        ],
    )
    .doc("Lutra: messages that stay in a full spool when the others have gone.");
    pub const SPOOL_SIZE: Param<i64> = int("Spool Size", 2048, Unit::Mebibyte)
        .within(1, 1 << 20)
        .doc("Lutra: what may wait on disk for the shore; beyond that the oldest telemetry goes.");
    pub const SPOOL_FOLDER: Param<String> =
        text("Spool Folder", "").doc("Lutra: where it waits; empty for the agent's data folder.");
    pub const BYTE_BUDGET: Param<i64> = int("Byte Budget", 0, Unit::BytePerSecond)
        .within(0, 1 << 30)
        .doc("Lutra: what may be sent over time, newest values before the backlog; 0 does not limit it.");
    pub const SYNC_INTERVAL: Param<f64> = float("Sync Interval", 0.2, Unit::Second)
        .within(0.02, 60.0)
        .doc("Lutra: what the vessel said longer ago than this survives a loss of power.");

    pub static LUTRA: SectionSpec = SectionSpec::task(&["Transports.Lutra"], "Lutra Link", "Never")
        .doc("Carries everything to a Lutra server, and its commands back.")
        .groups(&[
            OF_EVERY_TASK,
            &[
                URL.spec,
                TOKEN_FILE.spec,
                AUTHORITY.spec,
                super::MESSAGES.spec,
                super::RATES.spec,
                KEPT_LONGEST.spec,
                SPOOL_SIZE.spec,
                SPOOL_FOLDER.spec,
                BYTE_BUDGET.spec,
                SYNC_INTERVAL.spec,
            ],
        ]);

    pub const WAY_URL: Param<String> =
        text("URL", "").doc("Lutra: where the server is by this way; empty for the URL of Transports.Lutra.");
    pub const INTERFACE: Param<String> = text("Interface", "")
        .doc("Lutra: network interface that it goes by, such as wwan0; empty for the computer's routes.");
    pub const SOURCE_ADDRESS: Param<String> = text("Source Address", "")
        .doc("Lutra: address of this computer that it goes from; empty for the computer's choice.");
    pub const METERED: Param<bool> = flag("Metered", false)
        .doc("Lutra: whether its bytes cost, so that records go by another where one is good.");
    pub const DAILY_BUDGET: Param<i64> = int("Daily Budget", 0, Unit::Mebibyte).within(0, 1 << 20).doc(
        "Lutra: what a metered way may carry in a day (UTC), thinned from 70 % on; 0 does not limit it.",
    );

    pub static WAY: SectionSpec = SectionSpec::task(&["Transports.LutraWay"], "Way", "Never")
        .doc("One of several ways to the Lutra server, such as Transports.LutraWay/4G, called by its label.")
        .groups(&[
            OF_EVERY_TASK,
            &[WAY_URL.spec, INTERFACE.spec, SOURCE_ADDRESS.spec, METERED.spec, DAILY_BUDGET.spec],
        ]);
}
