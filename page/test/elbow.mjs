// An elbow's board driven from the page in headless Chromium, with pictures: told of its rig, calibrated, accepted.
//
//     node test/elbow.mjs [FOLDER]        the picture of docs/page.md goes there; without it, all of them into target/page

import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { browser, launch, play, press, root, says, view } from "./browsing.mjs";

const pictures = process.argv[2] ?? join(root, "target", "page");
const snap = async (page, name) => {
  if (process.argv[2] === undefined || name === "elbow") await page.screenshot({ path: join(pictures, `${name}.png`) });
};

/** What the example's file says, as parameters; the drawing is the one of the defaults. */
function ofTheFile(text) {
  const values = { geometry: 2, hinge_cables: 4, hinge_drawing: 1 };
  for (const key of ["base", "end"]) {
    [...text.matchAll(new RegExp(`^${key} = \\[(.*?)\\]`, "gm"))].forEach(([, point], cable) =>
      point.split(",").forEach((number, axis) => { values[`cable_${cable + 1}_${key}_${"xyz"[axis]}`] = Number(number); }));
  }
  /^home = \[(.*?)\]/m.exec(text)[1].split(",").forEach((length, cable) => { values[`home_${cable + 1}`] = Number(length); });
  return values;
}

/** Tells the board what it is, over the page's own line. */
async function tell(page, values) {
  await page.waitForFunction(() => window.glenoid.model.versions !== null);
  const codes = await page.evaluate(async (values) => {
    const { library, device } = window.glenoid;
    const answers = [];
    for (const [name, value] of Object.entries(values)) {
      const { index, single } = library.parameters.find((known) => known.name === name);
      const view = new DataView(new ArrayBuffer(4));
      if (single) view.setFloat32(0, value);
      else view.setUint32(0, value);
      answers.push(await device.parameter("Write", index, view.getUint32(0)));
    }
    answers.push(await device.parameter("Save"));
    return answers.map((answer) => answer?.code);
  }, values);
  assert.ok(codes.every((code) => code === 0), `the board refuses: ${codes}`);
  // the picture is that of the elbow's machine once its parameters have been read
  await page.waitForFunction(() => window.glenoid.model.isHinge && window.glenoid.library.machine.joint === "hinge");
}

/** The true angle of the person now, degrees. */
function angleNow(board) {
  return board.ask("where", /as it is now: (\S+) degrees/).then(([, degrees]) => Number(degrees));
}

/** To the review. On a machine that stalls, the board sees encoders that leap and rightly ends the run: it is begun again. */
async function run(page) {
  const accept = page.getByRole("button", { name: "Accept", exact: true });
  for (let tries = 0; tries < 600 && !(await accept.isVisible()); tries += 1) {
    const start = page.getByRole("button", { name: "Start", exact: true });
    if (await start.isVisible()) await start.click({ timeout: 1000 }).catch(() => undefined);
    await page.waitForTimeout(1000);
    if (await page.evaluate(() => window.glenoid.model.whole(false).length) === 10) await snap(page, "elbow-collecting");
  }
  await says(page, "Decide");
}

async function calibrate(page) {
  await says(page, "Hold the arm still and press Start");
  await snap(page, "elbow-ready");
  assert.equal(await page.getByRole("button", { name: "Start, blade held first" }).isVisible(), false);
  await run(page);
  await says(page, "Second set");
  await says(page, "The direction is known to");
  await page.waitForTimeout(1500);
  await snap(page, "elbow-review");
  await press(page, "Accept");
  await says(page, "Use this axis?");
  await press(page, "Yes, use it");
  await says(page, "Accepted. The new axis is in use.");
  await says(page, "Bent by");
  await page.waitForTimeout(1500);
  await snap(page, "elbow");
}

/** The axis in use is the person's, and so is the angle, from the pose in which both directions are the same. */
async function isTheTrueAxis(page, board) {
  const live = await page.evaluate(() => window.glenoid.model.liveHinge);
  const [found, truth] = [live.slice(0, 3).map(({ value }) => value), board.axis];
  const cross = [0, 1, 2].map((k) => found[(k + 1) % 3] * truth[(k + 2) % 3] - found[(k + 2) % 3] * truth[(k + 1) % 3]);
  const [off, sigma] = [Math.hypot(...cross), Math.hypot(...live.slice(0, 3).map(({ sigma }) => sigma))];
  console.log(`axis ${found.map((value) => value.toFixed(4))}, true ${truth}: ${off.toFixed(5)} rad apart, 1 sigma ${sigma.toFixed(5)}`);
  assert.ok(sigma > 0 && sigma < 0.1 && off < 5 * sigma + 4e-4, "not the person's axis");
  const [degrees, angle] = [await angleNow(board), await page.evaluate(() => window.glenoid.model.angle.value * 180 / Math.PI)];
  console.log(`bent by ${angle.toFixed(2)} degrees, true ${degrees}`);
  assert.ok(Math.abs(degrees - angle) < 3, "not the person's angle");
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

if (browser === undefined) {
  console.log("no Chromium here: the page is not driven");
  process.exit(process.env.GLENOID_REQUIRE_BROWSER ? 1 : 0);
}
mkdirSync(pictures, { recursive: true });
const launched = await launch();
const { context } = launched;
const errors = [];
const rig = join(root, "examples", "elbow.toml");
const board = await view("--rig", rig, "--hold", "600");
await play(board, launched, pictures, errors, async () => {
  const page = await context.newPage();
  page.on("pageerror", (error) => errors.push(String(error)));
  await page.goto(board.address);
  await tell(page, ofTheFile(readFileSync(rig, "utf8")));
  await calibrate(page);
  await isTheTrueAxis(page, board);
  await numbering(page, board);
});
