// What the page says of an elbow in words, which joint a recording is of, and requests that come too fast for the board.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { Device } from "../src/device.ts";
import { inPicture } from "../src/hinge.ts";
import { Library, type Message } from "../src/library.ts";
import { HINGE_NUMBERS, Model } from "../src/model.ts";
import { explained, guidance } from "../src/panel.ts";
import { jointOf } from "../src/source/joint.ts";
import { readRecording, type Recording } from "../src/source/recording.ts";

const library = await Library.load(readFileSync("page/dist/page.wasm"));
const code = (name: string) => library.words.reasons.find(([, known]) => known === name)![0];
const state = (name: string) => library.words.states.find(([, known]) => known === name)![0];
const [BALL, ELBOW] = [new Model(), new Model({ isHinge: true, cables: 4 })];

test("of an elbow the words are about its axis, of a shoulder about its centre", () => {
  assert.equal(explained(ELBOW, library, code("Rejected")).text, "The new axis was rejected; the old one stays in use.");
  assert.equal(explained(BALL, library, code("Rejected")).text, "The new centre was rejected; the old one stays in use.");
  assert.equal(explained(ELBOW, library, code("StrapSlipped")).text, "The axis has moved in the base: the strap slipped.");
  // there is nothing to do then
  assert.equal(explained(BALL, library, code("Rejected")).remedy, "");
  const decide = library.words.guidance.find(([, , name]) => name === "Decide")![0];
  const heartbeat = { name: "Heartbeat", state: state("Review"), reason: 0, guidance: decide, run_id: 1 } as Message;
  const situation = { connected: true, silent: false, recording: false, complaint: "" };
  for (const [model, joint] of [[new Model({ isHinge: true, cables: 4 }), "axis"], [new Model(), "centre"]] as const) {
    model.take(heartbeat);
    assert.equal(guidance(model, library, situation).text, `Accept or reject the new ${joint}.`);
  }
});

test("the picture is of the new axis, beside the one in use, only while it waits for a decision", () => {
  const model = new Model({ isHinge: true, cables: 4 });
  assert.equal(inPicture(model, "Idle").numbers, null);
  model.candidateHinge = Array(HINGE_NUMBERS).fill({ value: 1, sigma: 0.1 });
  assert.equal(inPicture(model, "Review").numbers![0]!.value, 1);
  assert.equal(inPicture(model, "Review").old, null);
  model.liveHinge = Array(HINGE_NUMBERS).fill({ value: 2, sigma: 0.1 });
  assert.deepEqual([inPicture(model, "Review").numbers![0]!.value, inPicture(model, "Review").old![0]!.value], [1, 2]);
  assert.deepEqual([inPicture(model, "Idle").numbers![0]!.value, inPicture(model, "Idle").old], [2, null]);
});

const [HEARTBEAT, LENGTH, AXIS, MODULE] = ["681#0000000000000000", "68F#010000", "6A3#0100000000000000", "6A2#"];
const joint = (frames: string[]) => {
  const lines = frames.map((frame, index) => `(${1700000000 + index}.0) can0 ${frame}`).join("\n");
  const { base, block } = library.words;
  return jointOf(readRecording(new TextEncoder().encode(lines), base, block) as Recording, (id, data) => library.decode(id, data));
};
/** The length of a cable in the first pose. */
const length = (cable: number) => `${LENGTH}0${cable}0000000D`;

test("a recording that does not hold what the board is, is of an elbow if something of a hinge is in it", () => {
  const shoulder = [HEARTBEAT, ...[1, 2, 3, 4, 5, 6].map(length)];
  assert.deepEqual(joint(shoulder), { isHinge: false, cables: 6 });
  assert.deepEqual(joint([HEARTBEAT, ...[1, 2, 3].map(length), AXIS]), { isHinge: true, cables: 3 });
  assert.deepEqual(joint([HEARTBEAT, AXIS]), { isHinge: true, cables: 4 });
  // what the board says itself counts, wherever it stands
  assert.deepEqual(joint([HEARTBEAT, length(1), AXIS, `${MODULE}0102301000000000`]), { isHinge: true, cables: 2 });
  assert.deepEqual(joint([...shoulder, `${MODULE}0006301000000000`]), { isHinge: false, cables: 6 });
});

test("a request that comes too fast is made again, not taken as refused", async () => {
  const tooMany = code("TooManyCommands");
  const asked: string[] = [];
  const device = new Device(library, (line) => {
    asked.push(new TextDecoder().decode(line));
    // byte 2 of the request is its nonce: after "t", three digits of the identifier, one of the length, two bytes
    const nonce = parseInt(asked.at(-1)!.slice(9, 11), 16);
    const answer = { name: "Parameter", parameter: 168, nonce, code: asked.length === 1 ? tooMany : 0, bits: 8 } as Message;
    queueMicrotask(() => device.take(answer));
  });
  assert.equal((await device.parameter("Write", 168, 8))!["code"], 0);
  assert.equal(asked.length, 2);
});
