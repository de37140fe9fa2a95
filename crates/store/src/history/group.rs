//! A series: the samples of one message from one entity of one system.

/// The key of a series of samples: message, system, entity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GroupKey {
    /// Id of the message.
    pub id: u16,
    /// Address of the system.
    pub src: u16,
    /// Number of the entity.
    pub src_ent: u8,
}
