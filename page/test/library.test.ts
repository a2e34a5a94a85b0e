// The library in WebAssembly: the same bits as on the host, and the same messages as cantools sees.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { type Identification, Library } from "../src/library.ts";
import { bitsOf, shortest } from "../src/parameters.ts";

const library = await Library.load(readFileSync("page/dist/page.wasm"));

/** A random number, the same every time (mulberry32). */
function random(seed: number): () => number {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

type V = [number, number, number];
const about = (axis: V, angle: number, v: V): V => {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const dot = axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2];
  const cross: V = [axis[1] * v[2] - axis[2] * v[1], axis[2] * v[0] - axis[0] * v[2], axis[0] * v[1] - axis[1] * v[0]];
  return v.map((value, k) => value * c + cross[k]! * s + axis[k]! * dot * (1 - c)) as V;
};
const circle = (radius: number, degrees: number, z = 0): V => {
  const angle = (degrees * Math.PI) / 180;
  return [radius * Math.cos(angle), radius * Math.sin(angle), z];
};

/** The true centre with the arm turned by about this rotation vector, rad, where it moves by so much with each radian, mm. */
const centreAt = ([x, y, z]: V, moves: number): V =>
  [7 + moves * (y + z / 6), -4 + moves * (z / 6 - x), 155 + moves * (x + y) / 3];

/** Lengths of an arm with its centre at (7, -4, 155), as singles; `moves` as there. */
function arm(poses: number, noise: number, seed = 1, baseRadius = 150, moves = 0): number[][] {
  const next = random(seed);
  const base = [0, 120, 240].map((degrees) => circle(baseRadius, degrees));
  const ends = [60, 180, 300].map((degrees) => circle(Math.sqrt(140.8 ** 2 - 96 ** 2), degrees, 96));
  return Array.from({ length: poses }, () => {
    const [azimuth, tilt, torsion] = [next() * 2 * Math.PI, next() * 0.78, (next() - 0.5) * 1.04];
    const [x, y] = [Math.cos(azimuth), Math.sin(azimuth)];
    const centre = centreAt([x * tilt, y * tilt, torsion], moves);
    const moved = ends.map((end) => {
      const turned = about([x, y, 0], tilt, about([0, 0, 1], torsion, end));
      return turned.map((value, k) => value + centre[k]!) as V;
    });
    const pairs = [[0, 0], [0, 1], [1, 1], [1, 2], [2, 2], [2, 0]] as const;
    return pairs.map(([end, point]) =>
      Math.fround(Math.hypot(...moved[end]!.map((value, k) => value - base[point]![k]!)) + (next() - 0.5) * 2 * noise));
  });
}

test("the centre is the true one, and each pose stands where the arm stood", () => {
  const found = library.identify(arm(20, 0))!;
  assert.equal(found.refusal, null);
  [7, -4, 155].forEach((value, k) => assert.ok(Math.abs(found.centre![k]! - value) < 2e-3, String(found.centre)));
  for (const pose of found.poses) {
    assert.ok(pose!.residuals!.every((left) => Math.abs(left) < 1e-3));
    [7, -4, 155].forEach((value, k) => assert.ok(Math.abs(pose!.centre![k]! - value) < 0.02));
  }
});

/** The largest that any cable leaves in any pose, mm. */
const largest = (found: Identification) => Math.max(...found.poses.flatMap((pose) => pose!.residuals!).map(Math.abs));

test("what a pose leaves is held against the machine as it is estimated, of a moving joint too", () => {
  for (const [moves, isMoving] of [[0, false], [6, true]] as const) {
    // within the tolerance of the encoders' zeros, 0.3 mm
    const poses = arm(40, 0.05, 2, 150, moves).map((row) => row.map((length, k) => length + (k === 2 ? 0.3 : 0)));
    const found = library.identify(poses)!;
    assert.equal(found.moving, isMoving, String(found.refusal));
    assert.ok(largest(found) < 0.12, `${largest(found)} mm are left`);
  }
});

test("WebAssembly and the host agree in every digit", () => {
  const host = (poses: number[][]) => JSON.parse(execFileSync("target/release/examples/identify", {
    input: poses.map((row) => row.join(" ")).join("\n"), encoding: "utf8",
  }));
  let accepted = 0;
  for (let seed = 1; seed <= 20; seed += 1) {
    const poses = arm(6 + seed, 0.1, seed);
    const here = library.identify(poses)!;
    accepted += here.centre === null ? 0 : 1;
    assert.deepEqual(here, host(poses), `seed ${seed}`);
  }
  assert.ok(accepted > 15, `${accepted} of 20 identified`);
});

test("too few poses, nonsense and none at all are refused in words", () => {
  for (const poses of [[], arm(2, 0), [[1, 2, 3, 4, 5, 6]], [[NaN, 1, 1, 1, 1, 1]], [[0, 0, 0, 0, 0, 0]]]) {
    const found = library.identify(poses)!;
    assert.equal(found.centre, null);
    assert.ok(found.refusal!.length > 5);
  }
  assert.equal(library.place([1, 2, 3, 4, 5, 6]), null);
});

test("an outlier is named with its cable", () => {
  const poses = arm(20, 0.05);
  poses[7]![2]! += 5;
  assert.deepEqual(library.identify(poses)!.rejected, [[7, 1 << 2]]);
});

test("lines of an adapter become messages, however they are cut", () => {
  // RawLength: run 3, pose 2, cable 5 of the second set, 256.5 mm; then a bell, an answer, a foreign frame
  const length = (256.5 * 2 ** 20).toString(16).padStart(8, "0").match(/../g)!.reverse().join("");
  const line = new TextEncoder().encode(`t68F8030002 15${length}\r`.replace(" ", ""));
  const all = new Uint8Array([7, 13, ...line, ...new TextEncoder().encode("z\rt18120102\r"), ...line]);
  for (const size of [1, 3, 1000]) {
    const heard = [];
    for (let at = 0; at < all.length; at += size) heard.push(...library.receive(all.subarray(at, at + size)));
    assert.deepEqual(heard, Array(2).fill({ name: "RawLength", run_id: 3, index: 2, cable: 5, held_out: 1, length: 256.5 }));
  }
});

test("random bytes never break the codec", () => {
  const next = random(5);
  const bytes = () => Uint8Array.from({ length: 2000 }, () => Math.floor(next() * 256));
  for (let round = 0; round < 200; round += 1) library.receive(bytes());
  for (let round = 0; round < 5000; round += 1) {
    library.decode(0x680 + Math.floor(next() * 32), bytes().subarray(0, Math.floor(next() * 12)));
  }
});

test("a command is a line with nonce, run and argument in their places", () => {
  const text = new TextDecoder().decode(library.command("ReadPose", 0x102, 0x105, 0x304));
  assert.equal(text, "t680809000403020105" + "01\r");
  assert.equal(library.command("Nonsense", 0, 0, 1).length, 0);
});

/** The board's parameters with these values instead, as it sends them. */
function parameters(values: Record<string, number>): [number, number][] {
  for (const name of Object.keys(values)) assert.ok(library.parameters.some((known) => known.name === name), name);
  return library.parameters.map((known) => [known.index, bitsOf(known, values[known.name] ?? known.default)]);
}

test("the machine is the one that the board's parameters make", () => {
  const [poses, shoulder] = [arm(12, 0.05), library.machine];
  const before = library.identify(poses)!;
  assert.equal(library.configure(parameters({})), "");
  assert.deepEqual([library.machine, library.identify(poses)], [shoulder, before]);
  // attachment points on a circle of 170 mm
  const wider: Record<string, number> = {};
  [0, 120, 240].forEach((degrees, point) => circle(170, degrees).forEach((value, axis) => {
    wider[`base_${point + 1}_${"xyz"[axis]}`] = value;
  }));
  assert.equal(library.configure(parameters(wider)), "");
  assert.ok(Math.abs(library.machine.base[0]![0]! - 170) < 1e-4);
  const found = library.identify(arm(20, 0, 1, 170))!;
  [7, -4, 155].forEach((value, k) => assert.ok(Math.abs(found.centre![k]! - value) < 2e-3, String(found.centre)));
  // two attachment points in one place: named, and the machine stays
  assert.match(library.configure(parameters({ base_2_x: 150, base_2_y: 0 })), /^base_\d_/);
  assert.ok(Math.abs(library.machine.base[0]![0]! - 170) < 1e-4);
  assert.equal(library.configure(parameters({})), "");
});

test("every cable may have ends of its own and a pulley", () => {
  const values: Record<string, number> = { geometry: 1 };
  library.machine.base.forEach((from, cable) => {
    const to = library.machine.ends[cable]!;
    "xyz".split("").forEach((axis, k) => {
      values[`cable_${cable + 1}_base_${axis}`] = from[k]!;
      values[`cable_${cable + 1}_end_${axis}`] = to[k]!;
    });
    values[`cable_${cable + 1}_pulley_radius`] = 5;
  });
  const poses = arm(20, 0);
  assert.equal(library.configure(parameters(values)), "");
  // lengths without pulleys do not fit a machine with pulleys
  const other = library.identify(poses)!.centre;
  assert.ok(other === null || Math.hypot(...other.map((value, k) => value - [7, -4, 155][k]!)) > 0.5, String(other));
  assert.ok(library.machine.home !== null);
  for (const cable of [1, 2, 3, 4, 5, 6]) values[`cable_${cable}_pulley_radius`] = 0;
  assert.equal(library.configure(parameters(values)), "");
  library.identify(poses)!.centre!.forEach((value, k) => assert.ok(Math.abs(value - [7, -4, 155][k]!) < 2e-3));
  assert.equal(library.configure(parameters({})), "");
});

test("a request about a parameter and its answer", () => {
  const text = (bytes: Uint8Array) => new TextDecoder().decode(bytes);
  // Write (2) hold_time (161): operation in the low four bits, index above, nonce, nothing, the value
  assert.equal(text(library.parameterRequest("Write", 161, 7, 500)), "t6988120A0700F4010000\r");
  assert.equal(library.parameterRequest("Nonsense", 161, 7, 500).length, 0);
  const answer = library.decode(0x699, Uint8Array.of(0x12, 0x0a, 7, 0, 0xf4, 1, 0, 0));
  assert.deepEqual(answer, { name: "Parameter", operation: 2, parameter: 161, nonce: 7, code: 0, bits: 500 });
});

test("values are shown with as many digits as they have, and come back to the bit", () => {
  const base = library.parameters.find(({ name }) => name === "base_2_y")!;
  assert.equal(shortest(base, bitsOf(base, 150)), "150");
  assert.equal(bitsOf(base, 150), 0x43160000);
  const next = random(9);
  for (let round = 0; round < 2000; round += 1) {
    const value = Math.fround((next() - 0.5) * 10 ** Math.floor(next() * 8 - 4));
    assert.equal(Math.fround(Number(shortest(base, bitsOf(base, value)))), value);
  }
  const documented = readFileSync("docs/parameters.md", "utf8");
  for (const known of library.parameters) {
    const range = [known.default, known.minimum, known.maximum].map((value) => shortest(known, bitsOf(known, value)));
    assert.ok(documented.includes(`| ${known.index} | \`${known.name}\` | ${known.single ? "single" : "integer"} | ${known.unit} |`), known.name);
    assert.ok(documented.includes(`| ${range.join(" | ")} | ${known.guarded ? "yes" : ""} | ${known.text} |`), `${known.name} ${range}`);
  }
});
