// Recordings and a stand-in for the browser's serial interface.

import assert from "node:assert/strict";
import { test } from "node:test";
import { framesUntil, readRecording, type Recording } from "../src/source/recording.ts";
import { openSerial, type SerialPortLike } from "../src/source/webserial.ts";
import { words } from "../src/words.ts";

const read = (text: string) => readRecording(new TextEncoder().encode(text), 0x680, 32);

const recording = (text: string): Recording => {
  const opened = read(text);
  assert.notEqual(typeof opened, "string", String(opened));
  return opened as Recording;
};

test("candump's two forms and python-can's CSV are one recording", () => {
  const forms = [
    "(1700000000.5) can0 682#0100\n(1700000001.5) can0 181#FF\n(1700000002.0) can0 18FEF100#FF\n(1700000002.5) can0 68F#0102030405060708\n",
    "(1700000000.5) can0 682#0100 R\r\n(1700000002.5) can0 68F#0102030405060708 T\r\n",
    " (1700000000.5)  can0  682   [2]  01 00\n (1700000002.5)  can0  68F   [8]  01 02 03 04 05 06 07 08\n",
    "timestamp,arbitration_id,extended,remote,error,dlc,data\n1700000000.5,0x682,0,0,0,2,AQA=\n1700000002.5,0x68f,0,0,0,8,AQIDBAUGBwg=\n",
  ];
  for (const form of forms) {
    const { times, ids, data, lengths, cut } = recording(form);
    assert.deepEqual([[...times], [...ids], [...lengths], cut], [[0, 2], [0x682, 0x68f], [2, 8], false], form);
    assert.deepEqual([...data.subarray(8, 16)], [1, 2, 3, 4, 5, 6, 7, 8], form);
  }
});

test("what is no recording, foreign, or cut says so", () => {
  for (const text of ["", "hello\nworld\n", "l1,l2\n1,2\n", "(1.0) can0 682#01\nnonsense\n(2.0) can0 682#01\n"]) {
    assert.equal(read(text), words.sources.notARecording, text);
  }
  assert.equal(read("(1.0) can0 181#01\n"), words.sources.foreign(0x680, 0x69f));
  assert.equal(recording("(1.0) can0 682#01\n(2.0) can0 68").cut, true);
});

test("an hour opens within five seconds, and any moment of it at once", () => {
  const lines: string[] = [];
  // heartbeats, and eight frames fifty times a second
  for (let tick = 0; tick < 3600 * 50; tick += 1) {
    const time = (tick / 50).toFixed(3);
    if (tick % 5 === 0) lines.push(`(${time}) can0 682#0100100000000000`);
    for (const id of Array(8).fill("69B")) lines.push(`(${time}) can0 ${id}#0011223344556677`);
  }
  lines.push("(3599.99) can0 685#0100000000000000");
  const bytes = new TextEncoder().encode(lines.join("\n"));
  // of the processor: others may have it in between
  const used = (since: NodeJS.CpuUsage) => (process.cpuUsage(since).user + process.cpuUsage(since).system) / 1e6;
  const begin = process.cpuUsage();
  const opened = readRecording(bytes, 0x680, 32) as Recording;
  const seconds = used(begin);
  assert.equal(opened.ids.length, lines.length);
  assert.ok(seconds < 5, `${seconds.toFixed(1)} s`);
  const seek = process.cpuUsage();
  // of what streams only the last 32 of each count
  assert.equal(framesUntil(opened, 1800).length, 64);
  assert.equal(framesUntil(opened, 3600).length, 65);
  assert.ok(used(seek) < 1, `${used(seek).toFixed(2)} s for two moments`);
});

/** A port that hears and says bytes. */
function port(): SerialPortLike & { heard: number[]; say(text: string): void; unplug(): void; opened: unknown } {
  let controller!: ReadableStreamDefaultController<Uint8Array>;
  const heard: number[] = [];
  return {
    heard,
    opened: null,
    say: (text) => controller.enqueue(new TextEncoder().encode(text)),
    unplug: () => controller.error(new Error("The device has been lost.")),
    async open(options) {
      this.opened = options;
    },
    async close() {},
    readable: new ReadableStream({ start: (c) => void (controller = c) }),
    writable: new WritableStream({ write: (bytes) => void heard.push(...bytes) }),
  };
}

const soon = () => new Promise((resolve) => setTimeout(resolve, 20));

test("an adapter is opened at 500 kbit/s, heard, closed, and missed when it is unplugged", async () => {
  const [device, events] = [port(), [] as string[]];
  const listener = {
    bytes: (bytes: Uint8Array) => events.push(new TextDecoder().decode(bytes)),
    opened: () => events.push("opened"),
    gone: (reason: string) => events.push(reason),
  };
  const source = await openSerial({ requestPort: async () => device }, listener);
  assert.ok(typeof source !== "string");
  await soon();
  assert.equal(String.fromCharCode(...device.heard), "C\rS6\rO\r");
  device.say("t6828");
  device.say("0000000000000000\r");
  await soon();
  assert.deepEqual(events, ["opened", "t6828", "0000000000000000\r"]);
  device.unplug();
  await soon();
  assert.equal(events.at(-1), words.sources.gone);
});

test("closing tells the adapter, and is no loss", async () => {
  const [device, events] = [port(), [] as string[]];
  const source = await openSerial({ requestPort: async () => device }, {
    bytes: () => undefined, opened: () => undefined, gone: (reason) => void events.push(reason),
  });
  assert.ok(typeof source !== "string");
  source.close();
  await soon();
  assert.ok(String.fromCharCode(...device.heard).endsWith("C\r"));
  assert.deepEqual(events, []);
});

test("a browser without serial ports, a refusal and a busy adapter are told apart", async () => {
  const nobody = { bytes: () => undefined, opened: () => undefined, gone: () => undefined };
  assert.equal(await openSerial(undefined, nobody), words.sources.noSerial);
  assert.equal(await openSerial({ requestPort: () => Promise.reject(new Error("no")) }, nobody), words.sources.serialRefused);
  const busy = { ...port(), open: () => Promise.reject(new Error("busy")) };
  assert.equal(await openSerial({ requestPort: async () => busy }, nobody), words.sources.serialBusy);
});
