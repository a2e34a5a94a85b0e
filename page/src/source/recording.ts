// A recorded log: candump's two forms and python-can's CSV. Frames are kept as numbers; an hour of them is opened at once.

import { words } from "../words.ts";

export interface Recording {
  /** Seconds since the first frame, rising. */
  times: Float64Array;
  ids: Uint16Array;
  /** Eight bytes a frame. */
  data: Uint8Array;
  lengths: Uint8Array;
  cut: boolean;
}

const CANDUMP = /^\s*\(([\d.]+)\)\s+\S+\s+([0-9A-Fa-f]{3})#([0-9A-Fa-f]*)(?:\s+[TR])?\s*$/;
const PRINTED = /^\s*(?:\(([\d.]+)\)\s+)?\S+\s+([0-9A-Fa-f]{3})\s+\[\d\]\s+((?:[0-9A-Fa-f]{2}\s*)*)/;
/** A frame that is not the board's: extended, remote, FD, error. */
const OTHER = /^\s*\([\d.]+\)\s+\S+\s+[0-9A-Fa-f]{3,8}#/;
const CSV_HEADER = "timestamp,arbitration_id,extended,remote,error,dlc,data";

interface Frame {
  time: number | null;
  id: number;
  data: Uint8Array;
}

/** Reads a recording; the answer is a complaint when it is none. */
export function readRecording(text: string): Recording | string {
  const lines = text.split(/\r?\n/);
  while (lines.length > 0 && lines[lines.length - 1]!.trim() === "") lines.pop();
  const csv = lines[0]?.trim() === CSV_HEADER;
  const times: number[] = [];
  const ids: number[] = [];
  const lengths: number[] = [];
  const data = new Uint8Array(8 * lines.length);
  let cut = false;
  let known = 0;
  for (let index = csv ? 1 : 0; index < lines.length; index += 1) {
    const line = lines[index]!;
    const frame = csv ? csvFrame(line) : candumpFrame(line);
    if (frame === undefined) {
      const last = index === lines.length - 1;
      if (!last || known === 0) return words.sources.notARecording;
      cut = true;
      break;
    }
    known += 1;
    // only the board's own: a bus may carry much else
    if (frame === null || frame.id < 0x300 || frame.id > 0x31f) continue;
    data.set(frame.data, 8 * ids.length);
    // what candump prints without a time stamp: a heartbeat comes ten times a second
    times.push(frame.time ?? (times.length > 0 ? times[times.length - 1]! + 0.01 : 0));
    ids.push(frame.id);
    lengths.push(frame.data.length);
  }
  if (known === 0) return words.sources.notARecording;
  if (ids.length === 0) return words.sources.foreign;
  const begin = times[0]!;
  return {
    times: Float64Array.from(times, (time) => time - begin),
    ids: Uint16Array.from(ids),
    data: data.slice(0, 8 * ids.length),
    lengths: Uint8Array.from(lengths),
    cut,
  };
}

/** undefined: no frame; null: a frame that is not for us. */
function candumpFrame(line: string): Frame | null | undefined {
  const match = CANDUMP.exec(line) ?? PRINTED.exec(line);
  if (match === null) return OTHER.test(line) ? null : undefined;
  const data = bytes(match[3]!.replaceAll(" ", ""));
  return data && { time: match[1] === undefined ? null : Number(match[1]), id: parseInt(match[2]!, 16), data };
}

function csvFrame(line: string): Frame | null | undefined {
  const [time, id, extended, remote, error, , payload] = line.split(",");
  if (payload === undefined || time === undefined || id === undefined) return undefined;
  if (extended === "1" || remote === "1" || error === "1") return null;
  let data: Uint8Array;
  try {
    data = Uint8Array.from(atob(payload.trim()), (character) => character.charCodeAt(0));
  } catch {
    return undefined;
  }
  return data.length > 8 ? null : { time: Number(time), id: parseInt(id, 16), data };
}

function bytes(digits: string): Uint8Array | undefined {
  if (digits.length % 2 !== 0 || digits.length > 16) return undefined;
  return Uint8Array.from(digits.match(/../g) ?? [], (pair) => parseInt(pair, 16));
}

/** Identifiers with more frames than this carry a stream: of those only the last one before a moment counts. */
const STREAM = 3000;

/** The frames that tell how things stood at a moment, in order, as indices. */
export function framesUntil(recording: Recording, seconds: number): number[] {
  const counts = new Map<number, number>();
  for (const id of recording.ids) counts.set(id, (counts.get(id) ?? 0) + 1);
  const last = new Map<number, number>();
  const frames: number[] = [];
  for (let index = 0; index < recording.ids.length && recording.times[index]! <= seconds; index += 1) {
    const id = recording.ids[index]!;
    if (counts.get(id)! > STREAM) last.set(id, index);
    else frames.push(index);
  }
  return [...frames, ...last.values()].sort((a, b) => a - b);
}
