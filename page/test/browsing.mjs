// What the tests in a browser share: a board with a person, the browser, its bus, looking and pressing.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { connect } from "node:net";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const root = join(dirname(fileURLToPath(import.meta.url)), "..", "..");
export const browser = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);

/** Starts `cargo view` and waits for its address. */
export function view(...options) {
  const child = spawn(join(root, "target", "release", "view"), ["--yes", "--port", "0", ...options], {
    stdio: ["pipe", "pipe", "inherit"],
  });
  return new Promise((resolve, reject) => {
    let said = "";
    child.on("exit", (code) => reject(new Error(`cargo view ended with ${code}: ${said}`)));
    child.stdout.on("data", (data) => {
      said += data;
      const address = /page\s+(http:\S+)/.exec(said);
      const bus = /CAN bus\s+socket:\/\/(\S+):(\d+)/.exec(said);
      if (address && bus && said.includes("Ctrl-C ends it")) {
        const order = (word) => child.stdin.write(`${word}\n`);
        const end = () => child.kill("SIGINT");
        const axis = /true axis (\S+) (\S+) (\S+) through/.exec(said)?.slice(1).map(Number);
        const asked = (order, wanted) => ask(child, order, wanted);
        resolve({ address: address[1], bus: [Number(bus[2]), bus[1]], axis, order, ask: asked, where: () => where(child), end });
      }
    });
  });
}

/** What the terminal says to an order. */
function ask(child, order, wanted) {
  let said = "";
  return new Promise((resolve) => {
    const hear = (data) => {
      said += data;
      const found = wanted.exec(said);
      if (found === null) return;
      child.stdout.off("data", hear);
      resolve(found);
    };
    child.stdout.on("data", hear);
    child.stdin.write(`${order}\n`);
  });
}

/** The person's true centre with the arm where it is now, mm. */
const where = (child) => ask(child, "where", /true centre, with the arm where it is now: (\S+) (\S+) (\S+) mm/)
  .then((truth) => truth.slice(1).map(Number));

/** Records the bus as candump -l does, from now on. */
export function recorder(board) {
  const lines = [];
  const socket = connect(...board.bus, () => socket.write("C\rS6\rO\r"));
  let waiting = "";
  socket.on("error", () => undefined);
  socket.on("data", (data) => {
    const parts = (waiting + data).split("\r");
    waiting = parts.pop();
    for (const line of parts) {
      const frame = /^\x07?t(...)(\d)([0-9A-F]*)/.exec(line);
      if (frame) lines.push(`(${(Date.now() / 1000).toFixed(6)}) can0 ${frame[1]}#${frame[3].slice(0, 2 * frame[2])}`);
    }
  });
  return { lines, end: () => socket.destroy() };
}

export const says = (page, text, timeout = 300_000) => page.getByText(text).first().waitFor({ timeout });
export const press = (page, name) => page.getByRole("button", { name, exact: true }).click();

/** Runs the scenes with a board; of what fails a picture stays, and what the page said. Ends the process. */
export async function play(board, { context, close }, pictures, errors, scenes) {
  try {
    await scenes();
    assert.deepEqual(errors, [], "the browser reports errors");
    console.log(`pictures in ${pictures}`);
  } catch (error) {
    for (const page of context.pages()) {
      console.log(`the page said: ${await page.locator("body").innerText({ timeout: 5_000 }).catch(() => "nothing")}`);
      await page.screenshot({ path: join(pictures, "failed.png") }).catch(() => undefined);
    }
    throw error;
  } finally {
    board.end();
    await close();
  }
  process.exit(0);
}

/** A browser with a profile of its own, which goes with it. */
export async function launch() {
  const profile = mkdtempSync(join(tmpdir(), "glenoid-browser-"));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: browser,
    viewport: { width: 1366, height: 900 },
    args: ["--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
      "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader"],
  });
  context.setDefaultTimeout(300_000);
  const close = async () => {
    await context.close();
    rmSync(profile, { recursive: true, force: true });
  };
  return { context, close };
}
