// An elbow: its machine and its angle in WebAssembly, what the page keeps of it, and what an accept names.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { type Message, Library } from "../src/library.ts";
import { HINGE_NUMBERS, Model } from "../src/model.ts";
import { bitsOf } from "../src/parameters.ts";

const library = await Library.load(readFileSync("page/dist/page.wasm"));

const BASE = [[42.4264, 42.4264, 0], [-42.4264, 42.4264, 0], [-42.4264, -42.4264, 0], [42.4264, -42.4264, 0]];
const ENDS = [[15.3909, 42.2862, 0], [-15.3909, 42.2862, 0], [-15.3909, -42.2862, 0], [15.3909, -42.2862, 0]];

/** The board's parameters of an elbow whose drawn axis is x through (0, 0, 160) in the base and (0, 0, -70) in the forearm. */
function parameters(): [number, number][] {
  const values: Record<string, number> = { geometry: 2, hinge_cables: 4, hinge_drawing: 1 };
  BASE.forEach((from, cable) => "xyz".split("").forEach((axis, k) => {
    values[`cable_${cable + 1}_base_${axis}`] = from[k]!;
    values[`cable_${cable + 1}_end_${axis}`] = ENDS[cable]![k]!;
  }));
  for (const cable of [1, 2, 3, 4]) values[`home_${cable}`] = 230;
  return library.parameters.map((known) => [known.index, bitsOf(known, values[known.name] ?? known.default)]);
}

/** Where a point of the forearm stands, turned by so much about x through a point of the base. */
function carried([x, y, z]: number[], angle: number, at: number[]): number[] {
  const [c, s, up] = [Math.cos(angle), Math.sin(angle), z! + 70];
  return [x! + at[0]!, y! * c - up * s + at[1]!, y! * s + up * c + at[2]!];
}

const lengths = (angle: number, at = [0, 0, 160]) => ENDS.map((end, cable) =>
  Math.hypot(...carried(end, angle, at).map((value, k) => value - BASE[cable]![k]!)));

test("the machine is an elbow's, and the forearm stands where its lengths say", () => {
  assert.equal(library.configure(parameters()), "");
  const { machine } = library;
  assert.equal(machine.joint, "hinge");
  assert.equal(machine.base.length, 4);
  [0, 0, -70].forEach((value, k) => assert.ok(Math.abs(machine.pivot![k]! - value) < 1e-4));
  for (const degrees of [-5, -40, -75, -115]) {
    const angle = (degrees * Math.PI) / 180;
    const placed = library.place(lengths(angle))!;
    assert.ok(Math.abs(placed.angle! - angle) < 1e-4, `${placed.angle} for ${angle}`);
    const [, , , , c] = placed.rotation;
    assert.ok(Math.abs(c! - Math.cos(angle)) < 1e-4);
    const end = carried([0, 0, 0], angle, [0, 0, 160]);
    end.forEach((value, k) => assert.ok(Math.abs(placed.origin[k]! - value) < 0.02, `${placed.origin} for ${end}`));
  }
  assert.equal(library.identify([[1, 2, 3, 4, 5, 6]]), null);
});

test("a hinge that the board shows takes the place of the drawn one, until there is none", () => {
  library.configure(parameters());
  // the same direction, through another point: 8 mm aside, 5 mm along the axis
  library.turnAbout([1, 0, 0, 0, 8, 150, 1, 0, 0, 0, 0, -70, 5]);
  assert.deepEqual(library.machine.nominal.map((value) => Math.round(value)), [5, 8, 150]);
  const placed = library.place(lengths(-1, [5, 8, 150]))!;
  assert.ok(Math.abs(placed.angle! + 1) < 1e-4, String(placed.angle));
  library.turnAbout([]);
  assert.deepEqual(library.machine.nominal.map((value) => Math.round(value)), [0, 0, 160]);
  // no numbers: the drawn one
  library.turnAbout(Array(HINGE_NUMBERS).fill(NaN));
  assert.deepEqual(library.machine.nominal.map((value) => Math.round(value)), [0, 0, 160]);
  assert.equal(library.place([NaN, 1, 2, 3]), null);
});

/** A component of a hinge as a frame, written out by hand: run, index (4 bits), value (28), sigma (16). */
function component(run: number, index: number, value: number, sigma: number): Uint8Array {
  const word = (index | (value << 4)) >>> 0;
  const bytes = [run & 255, run >> 8, word & 255, (word >>> 8) & 255, (word >>> 16) & 255, word >>> 24, sigma & 255, sigma >> 8];
  return Uint8Array.from(bytes);
}

/** CRC-16/IBM-3740. */
function crc(bytes: number[]): number {
  let sum = 0xffff;
  for (const byte of bytes) {
    sum ^= byte << 8;
    for (let bit = 0; bit < 8; bit += 1) sum = (sum & 0x8000 ? (sum << 1) ^ 0x1021 : sum << 1) & 0xffff;
  }
  return sum;
}

const [AXIS, PLACE, NAMING, MODULE, ANGLE] = [0x6a3, 0x6a4, 0x69d, 0x6a2, 0x6a7];

test("an accept names the hinge that was shown, and nothing that was not shown whole", () => {
  library.forget();
  const run = 0x102;
  // in the order of the report: axis and place in the base, in the forearm, what is left
  const order: [number, number][] = [0, 3].flatMap((from) =>
    [AXIS, PLACE].flatMap((id) => [0, 1, 2].map((k): [number, number] => [id, from + k])));
  order.push([PLACE, 6]);
  const frames = order.map(([id, index], k): [number, Uint8Array] => [id, component(run, index, 1000 + 7 * k, 20 + k)]);
  const last = frames.pop()!;
  for (const [id, data] of frames) library.decode(id, data);
  library.decode(NAMING, Uint8Array.of(2, 1, 5, 0, 9, 0, 0, 0));
  assert.equal(library.command("Accept", run, 0, 1).length, 0);
  library.decode(...last);
  const sum = crc([5, 0, 9, 0, ...[...frames, last].flatMap(([, data]) => [...data])]);
  const accept = library.words.opcodes.find(([, name]) => name === "Accept")![0];
  const bytes = [accept, 5, 1, 0, 2, 1, sum & 255, sum >> 8];
  const hex = bytes.map((byte) => byte.toString(16).padStart(2, "0").toUpperCase()).join("");
  assert.equal(new TextDecoder().decode(library.command("Accept", run, 0, 1)), `t6808${hex}\r`);
  assert.equal(library.command("Accept", run + 1, 0, 1).length, 0);
});

test("the page keeps the axis with its bar, the angle, and poses of four lengths", () => {
  library.forget();
  const model = new Model();
  const take = (id: number, data: Uint8Array) => model.take(library.decode(id, data) as Message);
  take(MODULE, Uint8Array.of(1, 4, 48, 16, 0, 0, 0, 0));
  assert.equal(model.isHinge, true);
  // 0.5 in steps of 2^-26 with 2^-10; 100 mm in steps of 2^-17 with 1/4 mm
  take(AXIS, component(3, 4, 2 ** 25, 2 ** 7));
  take(PLACE, component(3, 6, 100 * 2 ** 17, 2 ** 9));
  assert.deepEqual(model.candidateHinge[7], { value: 0.5, sigma: 2 ** -10 });
  assert.deepEqual(model.candidateHinge[12], { value: 100, sigma: 0.25 });
  // -1 rad in steps of 2^-14, 0.5 mm in steps of 2^-11
  const word = (((-(2 ** 14)) & 0x3ffff) | ((2 ** 10) << 18)) >>> 0;
  take(ANGLE, Uint8Array.of(3, 0, 0, 0, word & 255, (word >>> 8) & 255, (word >>> 16) & 255, word >>> 24));
  assert.deepEqual(model.angle, { value: -1, sigma: 0.5 });
  for (const cable of [1, 2, 3, 4]) {
    assert.equal(model.whole(false).length, 0);
    take(0x68f, Uint8Array.of(3, 0, 0, cable, 0, 0, 0, 13));
  }
  assert.deepEqual(model.whole(false).map(({ lengths }) => lengths), [[208, 208, 208, 208]]);
});
