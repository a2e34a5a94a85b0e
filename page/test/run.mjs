// Bundles the tests and runs them: Node.js does not read TypeScript everywhere yet.

import { build } from "esbuild";
import { spawnSync } from "node:child_process";
import { readdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const out = join(here, "..", "..", "target", "page-test");
const tests = readdirSync(here).filter((name) => name.endsWith(".test.ts"));
await build({
  entryPoints: tests.map((name) => join(here, name)),
  outdir: out,
  outExtension: { ".js": ".mjs" },
  bundle: true,
  platform: "node",
  format: "esm",
});
const files = tests.map((name) => join(out, name.replace(".ts", ".mjs")));
process.exit(spawnSync("node", ["--test", ...files], { stdio: "inherit", cwd: join(here, "..", "..") }).status ?? 1);
