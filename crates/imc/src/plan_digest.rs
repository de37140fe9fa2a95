//! The digests by which a console and a vehicle know that they have the same plans.

use crate::messages::PlanSpecification;
use crate::packet::{EncodeError, encode_payload};
use crate::wire::ByteOrder;
use md5::{Digest as _, Md5};

/// MD5 of a plan: over the little-endian payload of its `PlanSpecification`, without header and checksum.
///
/// This is `PlanDBInformation.md5`. The payload's length is `PlanDBInformation.plan_size`.
///
/// # Errors
/// When the plan does not fit a packet.
pub fn plan_md5(plan: &PlanSpecification) -> Result<[u8; 16], EncodeError> {
    Ok(payload_md5(&encode_payload(plan, ByteOrder::Little)?))
}

/// MD5 of a plan whose little-endian payload is at hand.
pub fn payload_md5(payload: &[u8]) -> [u8; 16] {
    Md5::digest(payload).into()
}

/// MD5 of a whole database: over the digests of its plans, ordered by plan id (`PlanDBState.md5`).
pub fn database_md5<'a>(plans: impl IntoIterator<Item = (&'a [u8], [u8; 16])>) -> [u8; 16] {
    let mut plans: Vec<_> = plans.into_iter().collect();
    plans.sort_by_key(|(plan_id, _)| *plan_id);
    let mut digest = Md5::new();
    for (_, md5) in plans {
        digest.update(md5);
    }
    digest.finalize().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_plans_give_the_digest_of_nothing() {
        assert_eq!(hex::encode(database_md5([])), "d41d8cd98f00b204e9800998ecf8427e");
    }

    #[test]
    fn plans_count_in_the_order_of_their_ids() {
        let (a, b) = ([1; 16], [2; 16]);
        assert_eq!(database_md5([(&b"b"[..], b), (b"a", a)]), payload_md5(&[a, b].concat()));
    }
}
