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
export function readRecording(bytes: Uint8Array, base: number, block: number): Recording | string {
  const last = lastByte(bytes);
  const text = new TextDecoder("latin1");
  const first = text.decode(bytes.subarray(0, endOfLine(bytes, 0))).trim();
  const csv = first === CSV_HEADER;
  const found = new Frames();
  let [known, cut] = [0, false];
  for (let at = csv ? endOfLine(bytes, 0) + 1 : 0; at < last; ) {
    const end = endOfLine(bytes, at);
    // nearly every line is one of candump -l; the others are looked at more slowly
    const quick = !csv && quickFrame(bytes, at, end, found);
    if (!quick) {
      const line = text.decode(bytes.subarray(at, end));
      const frame = csv ? csvFrame(line) : candumpFrame(line);
      if (frame === undefined) {
        if (end < last || known === 0) return words.sources.notARecording;
        cut = true;
        break;
      }
      if (frame !== null) found.push(frame.time, frame.id, frame.data);
    }
    known += 1;
    // only the board's own: a bus may carry much else
    if (found.lastId < base || found.lastId >= base + block) found.drop();
    at = end + 1;
  }
  if (known === 0) return words.sources.notARecording;
  if (found.count === 0) return words.sources.foreign(base, base + block - 1);
  return found.recording(cut);
}

/** Frames as they are read, in arrays that grow. */
class Frames {
  count = 0;
  private times = new Float64Array(1024);
  private ids = new Uint16Array(1024);
  private lengths = new Uint8Array(1024);
  private data = new Uint8Array(8 * 1024);

  /** Identifier of the last frame; -1 when there is none. */
  get lastId(): number {
    return this.count === 0 ? -1 : this.ids[this.count - 1]!;
  }

  push(time: number | null, id: number, data: ArrayLike<number>): void {
    if (this.count === this.times.length) this.grow();
    const before = this.count > 0 ? this.times[this.count - 1]! : 0;
    // what candump prints without a time stamp: a frame now and then
    this.times[this.count] = time ?? before + 0.01;
    this.ids[this.count] = id;
    this.lengths[this.count] = data.length;
    this.data.set(data, 8 * this.count);
    this.count += 1;
  }

  drop(): void {
    if (this.count > 0) this.count -= 1;
  }

  recording(cut: boolean): Recording {
    const { count } = this;
    const begin = this.times[0]!;
    return {
      times: this.times.subarray(0, count).map((time) => time - begin),
      ids: this.ids.slice(0, count),
      lengths: this.lengths.slice(0, count),
      data: this.data.slice(0, 8 * count),
      cut,
    };
  }

  private grow(): void {
    const twice = <A extends Float64Array | Uint16Array | Uint8Array>(old: A, made: A): A => {
      made.set(old);
      return made;
    };
    this.times = twice(this.times, new Float64Array(2 * this.times.length));
    this.ids = twice(this.ids, new Uint16Array(2 * this.ids.length));
    this.lengths = twice(this.lengths, new Uint8Array(2 * this.lengths.length));
    this.data = twice(this.data, new Uint8Array(2 * this.data.length));
  }
}

const [LINE_FEED, BLANK, OPEN, CLOSE, HASH, POINT, ZERO] = [10, 32, 40, 41, 35, 46, 48];

function endOfLine(bytes: Uint8Array, at: number): number {
  const end = bytes.indexOf(LINE_FEED, at);
  return end < 0 ? bytes.length : end;
}

/** Where the blanks at the end begin. */
function lastByte(bytes: Uint8Array): number {
  let last = bytes.length;
  while (last > 0 && bytes[last - 1]! <= BLANK) last -= 1;
  return last;
}

function hex(code: number): number {
  if (code >= 48 && code <= 57) return code - 48;
  const letter = code | 32;
  return letter >= 97 && letter <= 102 ? letter - 87 : -1;
}

const scratch = new Uint8Array(8);

/** A line `(1700000000.123456) can0 681#0102` of candump; false for every other line. */
function quickFrame(bytes: Uint8Array, begin: number, end: number, found: Frames): boolean {
  let at = begin;
  if (bytes[at] !== OPEN) return false;
  let [whole, part, scale, seenPoint] = [0, 0, 1, false];
  for (at += 1; at < end && bytes[at] !== CLOSE; at += 1) {
    const digit = bytes[at]! - ZERO;
    if (bytes[at] === POINT && !seenPoint) seenPoint = true;
    else if (digit < 0 || digit > 9) return false;
    else if (seenPoint) [part, scale] = [10 * part + digit, 10 * scale];
    else whole = 10 * whole + digit;
  }
  if (bytes[at] !== CLOSE || bytes[at + 1] !== BLANK) return false;
  at += 2;
  while (at < end && bytes[at] !== BLANK) at += 1;
  at += 1;
  let id = 0;
  for (let digit = 0; digit < 3; digit += 1, at += 1) {
    const value = at < end ? hex(bytes[at]!) : -1;
    if (value < 0) return false;
    id = 16 * id + value;
  }
  if (bytes[at] !== HASH) return false;
  at += 1;
  let length = 0;
  for (; at + 1 < end && bytes[at]! > BLANK; at += 2, length += 1) {
    const [high, low] = [hex(bytes[at]!), hex(bytes[at + 1]!)];
    if (high < 0 || low < 0 || length === 8) return false;
    scratch[length] = 16 * high + low;
  }
  // a carriage return may follow, nothing else
  if (at < end && bytes[at]! > BLANK || end - at > 1) return false;
  found.push(whole + part / scale, id, scratch.subarray(0, length));
  return true;
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

/** Identifiers with more frames than this carry a stream: of those only the last few before a moment count. */
const STREAM = 3000;
/** A set of values comes in up to so many frames: two of them hold a whole one. */
const LAST_OF_STREAM = 32;

/** The frames that tell how things stood at a moment, in order, as indices. */
export function framesUntil(recording: Recording, seconds: number): number[] {
  const counts = new Map<number, number>();
  for (const id of recording.ids) counts.set(id, (counts.get(id) ?? 0) + 1);
  const end = upperBound(recording.times, seconds);
  const taken = new Map<number, number>();
  const frames: number[] = [];
  // backwards, so that the last ones of a stream are known
  for (let index = end - 1; index >= 0; index -= 1) {
    const id = recording.ids[index]!;
    const stream = counts.get(id)! > STREAM;
    const count = taken.get(id) ?? 0;
    if (stream && count >= LAST_OF_STREAM) continue;
    taken.set(id, count + 1);
    frames.push(index);
  }
  return frames.reverse();
}

/** How many times are not after this moment. */
function upperBound(times: Float64Array, seconds: number): number {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle]! <= seconds) low = middle + 1;
    else high = middle;
  }
  return low;
}
