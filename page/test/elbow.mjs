// An elbow's board driven from the page in headless Chromium, with pictures: told of its rig, calibrated and accepted,
// calibrated again and rejected, and the recording of it all opened.
//
//     node test/elbow.mjs [FOLDER]        the picture of the decision goes there; without it, all of them into target/page

import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { browser, launch, play, press, recorder, root, says, view } from "./browsing.mjs";

const pictures = process.argv[2] ?? join(root, "target", "page");
/** The decision about an axis, beside the one in use. */
const documented = "elbow-review";
const snap = async (page, name) => {
  if (process.argv[2] === undefined || name === documented) await page.screenshot({ path: join(pictures, `${name}.png`) });
};

/** The person of this test is quick. */
const QUICK = { hold_time: 150, verification_poses: 3 };
const DRAWING = { axis: "hinge_axis", point: "hinge_point", axis_in_platform: "hinge_end_axis", point_in_platform: "hinge_end_point" };

/** What the example's file says, as parameters. A machine of which it states no tolerance is exactly as drawn; with the
 *  tolerances of the defaults two axes fit most sets of poses. */
function ofTheFile(text) {
  const values = { geometry: 2, hinge_cables: 0, hinge_drawing: 1 };
  for (const name of ["base", "edges", "offset", "drum"]) values[`tolerance_${name}`] = 0;
  const three = (name, numbers) => numbers.forEach((number, axis) => { values[`${name}_${"xyz"[axis]}`] = number; });
  for (const line of text.split("\n")) {
    if (line === "[[cable]]") values.hinge_cables += 1;
    const [, key, list] = /^(\w+) = \[(.*?)\]/.exec(line) ?? [];
    const numbers = (list ?? "").split(",").map(Number);
    if (key === "home") numbers.forEach((length, cable) => { values[`home_${cable + 1}`] = length; });
    else if (key === "base" || key === "end") three(`cable_${values.hinge_cables}_${key}`, numbers);
    else if (key === "range_deg") [values.hinge_lowest, values.hinge_highest] = numbers.map((degrees) => degrees * Math.PI / 180);
    else if (key !== undefined) three(DRAWING[key], numbers);
  }
  return values;
}

/** Tells the board what it is, over the page's own line. */
async function tell(page, values) {
  await page.waitForFunction(() => window.glenoid?.model.versions);
  const codes = await page.evaluate(async (values) => {
    const { library, device } = window.glenoid;
    // a board on a machine that stalls is asked again
    const asked = async (...request) => {
      for (let tries = 0; tries < 20; tries += 1) {
        const answer = await device.parameter(...request);
        if (answer !== null) return answer.code;
      }
      return null;
    };
    const codes = [];
    for (const [name, value] of Object.entries(values)) {
      const { index, single } = library.parameters.find((known) => known.name === name);
      const view = new DataView(new ArrayBuffer(4));
      if (single) view.setFloat32(0, value);
      else view.setUint32(0, value);
      codes.push(await asked("Write", index, view.getUint32(0)));
    }
    codes.push(await asked("Save"));
    return codes;
  }, values);
  assert.ok(codes.every((code) => code === 0), `the board refuses: ${codes}`);
  // the picture is that of the elbow's machine once its parameters have been read
  await page.waitForFunction(() => window.glenoid.model.isHinge && window.glenoid.library.machine.joint === "hinge");
}

/** The state of the board by name, the reason of it, which run and which start of the board. */
const standing = (page) => page.evaluate(() => {
  const { model, library, boot } = window.glenoid;
  const { state, reason } = model.heartbeat;
  return { state: library.state(Number(state)), reason: library.reason(Number(reason)).name, run: model.run, boot };
});

/** Waits until the board stands in one of these states, or another run is shown. */
const comesTo = (page, states, run, timeout) => page.waitForFunction(([states, run]) => {
  const { model, library } = window.glenoid;
  return model.run !== run || states.includes(library.state(Number(model.heartbeat.state)));
}, [states, run], { timeout });

/** Presses Start until a run has begun: while encoders are silent, on a machine that stalls, the board refuses it. */
async function begin(page) {
  const { run } = await standing(page);
  for (let tries = 0; tries < 300; tries += 1) {
    // it is not there any more once the run has begun
    await page.getByRole("button", { name: "Start", exact: true }).click({ timeout: 1000 }).catch(() => undefined);
    const begun = comesTo(page, ["Collecting", "Identifying", "Verifying", "Review"], run, 1000);
    if (await begun.then(() => true, () => false)) return;
  }
  assert.fail("no run begins");
}

/** A run to its review. Nothing may end it before, except what a machine that stalls long enough does to the emulated board:
 *  encoders leap, or its watchdog starts it anew. */
async function toReview(page) {
  for (;;) {
    await begin(page);
    const { run, boot } = await standing(page);
    await page.waitForFunction(() => window.glenoid.model.whole(false).length >= 10 || window.glenoid.model.outcome !== null,
      undefined, { timeout: 60_000 }).catch(() => undefined);
    await snap(page, "elbow-collecting");
    await comesTo(page, ["Review", "Failed", "Idle"], run, 600_000);
    const now = await standing(page);
    if (now.state === "Review") break;
    console.log(`the run ends early: ${JSON.stringify(now)}`);
    assert.ok(now.reason === "EncoderJumped" || now.boot !== boot, `the run fails: ${now.reason}`);
  }
  await says(page, "Second set");
  await says(page, "The direction is known to");
}

/** The thirteen numbers, once all of them are there. */
async function numbers(page, which) {
  const heard = await page.waitForFunction((which) => {
    const all = window.glenoid.model[which];
    return all.every((one) => one !== null) && all;
  }, which);
  return heard.jsonValue();
}

/** An axis may be named in either direction: 1 when this one is the person's, -1 when it is the other way round. */
const side = (found, board) => Math.sign(found.slice(0, 3).reduce((sum, { value }, k) => sum + value * board.axis[k], 0));

/** What is found is the person's axis. */
function isTheTrueAxis(numbers, board) {
  const [found, truth] = [numbers.slice(0, 3).map(({ value }) => value), board.axis];
  const cross = [0, 1, 2].map((k) => found[(k + 1) % 3] * truth[(k + 2) % 3] - found[(k + 2) % 3] * truth[(k + 1) % 3]);
  const [off, sigma] = [Math.hypot(...cross), Math.hypot(...numbers.slice(0, 3).map(({ sigma }) => sigma))];
  console.log(`axis ${found.map((value) => value.toFixed(4))}, true ${truth}: ${off.toFixed(5)} rad apart, 1 sigma ${sigma.toFixed(5)}`);
  assert.ok(sigma > 0 && sigma < 0.1 && off < 5 * sigma + 4e-4, "not the person's axis");
}

/** The angle comes to the person's: while one of both is older than the other, the arm may have moved between. */
async function isTheTrueAngle(page, board, sense) {
  for (let tries = 0; tries < 300; tries += 1) {
    const [, degrees] = await board.ask("where", /as it is now: (\S+) degrees/);
    const angle = sense * await page.evaluate(() => window.glenoid.model.angle.value * 180 / Math.PI);
    console.log(`bent by ${angle.toFixed(2)} degrees, true ${degrees}`);
    if (Math.abs(Number(degrees) - angle) < 3) return;
    await page.waitForTimeout(1000);
  }
  assert.fail("not the person's angle");
}

/** The first run: there is no other axis yet. */
async function accepted(page, board) {
  await says(page, "Hold the arm still and press Start");
  assert.equal(await page.getByRole("button", { name: "Start, blade held first" }).isVisible(), false);
  await says(page, "The angle is shown once an axis is in use.");
  await snap(page, "elbow-ready");
  await toReview(page);
  const candidate = await numbers(page, "candidateHinge");
  isTheTrueAxis(candidate, board);
  await snap(page, "elbow-first-review");
  await press(page, "Accept");
  await says(page, "Use this axis?");
  await snap(page, "elbow-confirm");
  await press(page, "Yes, use it");
  await says(page, "Accepted. The new axis is in use.");
  await says(page, "Bent by");
  assert.deepEqual(await numbers(page, "liveHinge"), candidate);
  await isTheTrueAngle(page, board, side(candidate, board));
  await snap(page, "elbow-accepted");
}

/** The second: the angle goes with the arm, the new axis stands beside the one in use, which a rejection leaves there. */
async function rejected(page, board) {
  const before = await numbers(page, "liveHinge");
  const [least, most] = await page.evaluate(() => {
    const { value } = window.glenoid.model.angle;
    const seen = window.seen = [value, value];
    const look = () => {
      const { value } = window.glenoid.model.angle ?? { value: seen[0] };
      [seen[0], seen[1]] = [Math.min(seen[0], value), Math.max(seen[1], value)];
      requestAnimationFrame(look);
    };
    look();
    return seen;
  });
  assert.equal(least, most);
  await toReview(page);
  const swept = await page.evaluate(() => (window.seen[1] - window.seen[0]) * 180 / Math.PI);
  console.log(`the angle went through ${swept.toFixed(0)} degrees`);
  // the board takes no set of poses that bends less
  assert.ok(swept > 40, `the angle shown went through ${swept} degrees only`);
  const fresh = await numbers(page, "candidateHinge");
  isTheTrueAxis(fresh, board);
  assert.notDeepEqual(fresh, before);
  // both are in the table, and how far they are apart
  const row = await page.locator("table.hinge tbody tr", { hasText: "direction x" }).first().locator("td").allInnerTexts();
  const shown = (value) => `${value.value.toFixed(4)} ± ${value.sigma.toFixed(4)}`;
  assert.deepEqual(row.slice(0, 2), [shown(fresh[0]), shown(before[0])]);
  assert.deepEqual(await page.locator(".actions button:visible").allInnerTexts(), ["Accept", "Reject"]);
  // nothing of it is cut off
  const [wide, room] = await page.locator(".figures").evaluate((box) => [box.scrollWidth, box.clientWidth]);
  assert.ok(wide <= room, `the figures want ${wide} px of ${room}`);
  await snap(page, "elbow-review");
  await press(page, "Reject");
  await says(page, "The new axis was rejected; the old one stays in use.");
  assert.deepEqual(await numbers(page, "liveHinge"), before);
  await isTheTrueAngle(page, board, side(before, board));
  await snap(page, "elbow-rejected");
}

/** The numbering of an elbow's four cables. */
async function numbering(page, board) {
  await press(page, "Check the cables …");
  for (let cable = 1; cable <= 4; cable += 1) {
    await says(page, `Pull cable ${cable}: base point ${cable} to end ${cable} on the forearm.`);
    board.order(`pull ${cable}`);
  }
  await says(page, "Every cable is at its own encoder.");
  await page.locator("#numbering").getByRole("button", { name: "Close" }).click();
}

/** The recording of both runs: the axis in use, and poses of four lengths. */
async function recording(page, lines, live) {
  await page.setInputFiles("#file", { name: "elbow.log", mimeType: "text/plain", buffer: Buffer.from(lines.join("\n")) });
  await page.locator("#recorded").waitFor();
  assert.deepEqual(await numbers(page, "liveHinge"), live);
  await page.waitForFunction(() => window.glenoid.model.isHinge && window.glenoid.model.whole(false).length >= 20);
  await snap(page, "elbow-recording");
}

if (browser === undefined) {
  console.log("no Chromium here: the page is not driven");
  process.exit(process.env.GLENOID_REQUIRE_BROWSER ? 1 : 0);
}
mkdirSync(pictures, { recursive: true });
const launched = await launch();
const { context } = launched;
const errors = [];
const rig = join(root, "examples", "elbow.toml");
const board = await view("--rig", rig, "--hold", "300");
await play(board, launched, pictures, errors, async () => {
  const page = await context.newPage();
  page.on("pageerror", (error) => errors.push(String(error)));
  await page.goto(board.address);
  await tell(page, { ...ofTheFile(readFileSync(rig, "utf8")), ...QUICK });
  const bus = recorder(board);
  await accepted(page, board);
  await rejected(page, board);
  bus.end();
  const live = await numbers(page, "liveHinge");
  await numbering(page, board);
  await recording(page, bus.lines, live);
});
