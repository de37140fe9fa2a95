//! The chart in the world: a file ashore, which may be read badly; a file and a part of another aboard.

use super::{Event, World};
use bytes::Bytes;
use link::{
    ChartAboard, ChartDigest, ChartOffer, ChartReport, ChartRequest, ConnectionId, ShoreInput, VesselInput,
};

#[derive(Debug, Default)]
pub(crate) struct ChartAshore {
    file: Bytes,
    digest: ChartDigest,
    /// The next part is read with a wrong byte.
    pub(crate) corrupt_next: bool,
    /// The vessel's last report.
    pub(crate) report: Option<ChartReport>,
    pub(crate) parts: u64,
}

#[derive(Debug, Default)]
pub(crate) struct ChartAtSea {
    /// On disk and in force.
    held: ChartDigest,
    /// On disk: the parts of another.
    part: Option<(ChartOffer, Vec<u8>)>,
    /// The disk's pending answer; lost with the program.
    answers: Vec<VesselInput>,
    /// Charts that were whole and not what their digest says.
    pub(crate) refused: u64,
    /// Bytes that came, and of them those that went into a chart that is whole.
    pub(crate) came: u64,
    pub(crate) used: u64,
}

/// Any function of the bytes that distinguishes two charts.
fn digest(bytes: &[u8]) -> ChartDigest {
    let mut digest = [0; 32];
    for (lane, eight) in (1_u64..).zip(digest.chunks_exact_mut(8)) {
        let hash = bytes.iter().fold(0xCBF2_9CE4_8422_2325 ^ lane, |hash: u64, byte| {
            (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01B3)
        });
        eight.copy_from_slice(&hash.to_le_bytes());
    }
    digest
}

impl World {
    /// The shore has another chart from here on, half of it noise.
    pub(crate) fn publish(&mut self, bytes: u64) {
        let mut file = Vec::new();
        while (file.len() as u64) < bytes {
            file.extend(self.chance.below(u64::MAX).to_le_bytes());
            file.extend([0; 8]);
        }
        self.shore.chart.digest = digest(&file);
        self.shore.chart.file = file.into();
        self.offer();
    }

    /// Reports the present chart to the shore's machine.
    pub(crate) fn offer(&mut self) {
        let ChartAshore { file, digest, .. } = &self.shore.chart;
        let offer = ChartOffer { digest: *digest, bytes: file.len() as u64, edition: "4".to_owned() };
        self.shore_handle(ShoreInput::Chart((!file.is_empty()).then_some(offer)));
    }

    pub(crate) fn shore_reads(&mut self, id: ConnectionId, ask: ChartRequest) {
        let chart = &mut self.shore.chart;
        chart.parts += 1;
        let (from, to) = (ask.offset as usize, ask.offset as usize + ask.length as usize);
        let mut bytes = chart.file.get(from..to).filter(|_| chart.digest == ask.digest).map(<[u8]>::to_vec);
        if let Some(byte) = bytes.as_mut().and_then(|bytes| bytes.first_mut()).filter(|_| chart.corrupt_next)
        {
            *byte ^= 1;
            chart.corrupt_next = false;
        }
        self.shore_handle(ShoreInput::ChartPart(id, ask, bytes.map(Bytes::from)));
    }

    /// Whether the vessel has the shore's chart in force.
    pub(crate) fn chart_is_aboard(&self) -> bool {
        self.vessel.chart.held == self.shore.chart.digest
    }

    /// Bytes of the shore's chart that are aboard and not in force.
    pub(crate) fn chart_bytes_aboard(&self) -> usize {
        self.vessel.chart.part.as_ref().map_or(0, |(_, bytes)| bytes.len())
    }

    /// What the vessel's program reports to its machine at its start.
    pub(crate) fn tell_chart_aboard(&mut self) {
        self.vessel.chart.answers.clear();
        self.vessel_handle(VesselInput::ChartAboard(self.vessel.chart.aboard()));
    }

    pub(crate) fn chart_begins(&mut self, offer: ChartOffer) {
        let chart = &mut self.vessel.chart;
        if chart.part.as_ref().is_none_or(|(known, _)| known.digest != offer.digest) {
            chart.part = Some((offer, Vec::new()));
        }
        self.chart_goes_on();
    }

    pub(crate) fn chart_part_came(&mut self, of: &ChartDigest, offset: u64, bytes: &[u8]) {
        let chart = &mut self.vessel.chart;
        let (offer, part) = chart.part.as_mut().unwrap();
        assert_eq!((offer.digest, part.len() as u64), (*of, offset), "in order");
        part.extend_from_slice(bytes);
        chart.came += bytes.len() as u64;
        self.chart_goes_on();
    }

    /// The disk answers a moment later.
    fn chart_goes_on(&mut self) {
        let chart = &mut self.vessel.chart;
        let Some((offer, part)) = &chart.part else { return };
        let of = offer.digest;
        let answers = if (part.len() as u64) < offer.bytes {
            vec![VesselInput::ChartGoOn(of, part.len() as u64)]
        } else if digest(part) == of {
            chart.used += part.len() as u64;
            (chart.held, chart.part) = (of, None);
            vec![VesselInput::ChartKept(of), VesselInput::ChartAboard(chart.aboard())]
        } else {
            chart.part = None;
            chart.refused += 1;
            vec![VesselInput::ChartFailed(of, "not what its digest says".to_owned())]
        };
        chart.answers = answers;
        let after = self.chance.below(10_000);
        self.at(after, Event::ChartDisk);
    }

    pub(crate) fn chart_disk_answers(&mut self) {
        for answer in std::mem::take(&mut self.vessel.chart.answers) {
            self.vessel_handle(answer);
        }
    }
}

impl ChartAtSea {
    fn aboard(&self) -> ChartAboard {
        ChartAboard { held: self.held, takes: true, ..ChartAboard::default() }
    }
}
