// The compact form of the live socket: one stream of raw DEFLATE, in which a series is described once and has samples after
// that. Frames come out as they would have been sent in full.

import type { LiveFrame, LiveSample, LiveSeries, Update } from "./types.gen";

/** Frames of one connection out of the bytes of its messages; each message holds one. */
export class Inflater {
  private readonly writer: WritableStreamDefaultWriter<BufferSource>;
  /** When the messages came whose frames are not out yet, ms of the steady clock. */
  private readonly came: number[] = [];
  private readonly series = new Map<number, LiveSeries>();
  private text = "";

  constructor(
    /** A frame, and when its message came, ms of the steady clock. */
    private readonly frame: (frame: LiveFrame, cameMs: number) => void,
    /** What came is not what a server sends: nothing more comes of this connection. */
    private readonly broken: () => void,
  ) {
    const stream = new DecompressionStream("deflate-raw");
    this.writer = stream.writable.getWriter();
    void this.read(stream.readable.getReader()).catch(() => this.broken());
  }

  take(message: ArrayBuffer, cameMs: number): void {
    this.came.push(cameMs);
    this.writer.write(new Uint8Array(message)).catch(() => this.broken());
  }

  private async read(reader: ReadableStreamDefaultReader<Uint8Array>): Promise<void> {
    const decoder = new TextDecoder();
    for (let part = await reader.read(); !part.done; part = await reader.read()) {
      const [end = "", ...next] = decoder.decode(part.value, { stream: true }).split("\n");
      this.text += end;
      for (const begun of next) {
        const frame = JSON.parse(this.text) as LiveFrame;
        this.text = begun;
        this.frame(inFull(frame, this.series), this.came.shift() ?? performance.now());
      }
    }
  }
}

/** A frame with the values that its samples are; `series` are those that were described, by their numbers. */
export function inFull(frame: LiveFrame, series: Map<number, LiveSeries>): LiveFrame {
  if (frame.snapshot) series.clear();
  for (const one of frame.series) series.set(one.series, one);
  const values = frame.samples.map((sample) => {
    const of = series.get(sample.series);
    if (!of) throw new Error(`a sample of series ${sample.series}, which was not described`);
    return update(of, sample);
  });
  return { ...frame, values, series: [], samples: [] };
}

function update({ system, id, abbrev, entity, instance, names, units }: LiveSeries, sample: LiveSample): Update {
  const { time_us, received_us, count, period_s, values, meanings } = sample;
  const fields = values.map((value, at) => ({ name: names[at] ?? "", value, unit: units[at] ?? "", meaning: meanings[at] ?? null }));
  return { system, id, abbrev, entity, instance, time_us, received_us, count, period_s, fields };
}
