//! The frames of a compressed file whose head or seek table is damaged, or whose end is cut off: found one after the other
//! from the start. A frame that cannot be found hides those behind it.

use super::table::{Coding, FRAME_BYTES, Frame, HEAD_BYTES, Head};
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt as _;
use zstd::zstd_safe::{find_frame_compressed_size, get_frame_content_size};

/// The digest of a file whose head is damaged.
pub(super) const UNKNOWN: [u8; 32] = [0; 32];
/// A whole frame is not longer: what zstd makes of noise, and more.
const MOST_BYTES: u64 = FRAME_BYTES as u64 + FRAME_BYTES as u64 / 128 + 1024;
const MAGIC: [u8; 4] = 0xFD2F_B528_u32.to_le_bytes();

/// The frames of a file with a whole head. Fewer than the head says if one of them cannot be found.
pub(super) fn frames(file: &File, head: &Head, file_bytes: u64) -> io::Result<Vec<Frame>> {
    let (mut at, mut found, mut bytes) = (HEAD_BYTES as u64, Vec::new(), Vec::new());
    for number in 0..head.frames() {
        let Some(frame) = frame(file, at, file_bytes, &mut bytes)? else { break };
        let plain = head.plain_in(number) as u32;
        let fits = match head.coding {
            Coding::Bytes => frame.unpacked == plain,
            Coding::Records => (1..=plain + 1).contains(&frame.unpacked),
        };
        if !fits {
            break;
        }
        at += u64::from(frame.packed);
        found.push(frame);
    }
    Ok(found)
}

/// A head and the frames of packets whose head is damaged; `None` if there is not one frame.
pub(super) fn frames_without_head(file: &File, file_bytes: u64) -> io::Result<Option<(Head, Vec<Frame>)>> {
    let (mut at, mut found, mut bytes) = (HEAD_BYTES as u64, Vec::<Frame>::new(), Vec::new());
    let mut plain_bytes = 0;
    while let Some(frame) = frame(file, at, file_bytes, &mut bytes)? {
        let frame_bytes = found.first().map_or(frame.unpacked, |first| first.unpacked);
        // All but the last frame have the length of the first.
        let is_behind_the_last = found.last().is_some_and(|last| last.unpacked < frame_bytes);
        if is_behind_the_last || !(1..=frame_bytes).contains(&frame.unpacked) {
            break;
        }
        at += u64::from(frame.packed);
        plain_bytes += u64::from(frame.unpacked);
        found.push(frame);
    }
    let head = found.first().map(|first| Head {
        coding: Coding::Bytes,
        frame_bytes: first.unpacked,
        plain_bytes,
        sha256: UNKNOWN,
    });
    Ok(head.map(|head| (head, found)))
}

/// The frame at a place, if a whole one of a length that can be is there.
fn frame(file: &File, at: u64, file_bytes: u64, bytes: &mut Vec<u8>) -> io::Result<Option<Frame>> {
    bytes.resize(file_bytes.saturating_sub(at).min(MOST_BYTES) as usize, 0);
    file.read_exact_at(bytes, at)?;
    if !bytes.starts_with(&MAGIC) {
        return Ok(None);
    }
    let (Ok(packed), Ok(Some(unpacked))) = (find_frame_compressed_size(bytes), get_frame_content_size(bytes))
    else {
        return Ok(None);
    };
    // Records that columns do not make smaller stand behind one byte.
    if packed == 0 || packed > bytes.len() || unpacked > u64::from(FRAME_BYTES) + 1 {
        return Ok(None);
    }
    Ok(Some(Frame { at, packed: packed as u32, unpacked: unpacked as u32 }))
}
