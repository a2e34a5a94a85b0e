// Builds the page into dist/: the library to WebAssembly, the sources into one file. Says how large it is compressed.

import { build } from "esbuild";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, readFileSync, readdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const LIMIT_KB = 300;
const here = dirname(fileURLToPath(import.meta.url));
const dist = join(here, "dist");
const target = "wasm32-unknown-unknown";

// a target folder may be shared with other checkouts
const metadata = execFileSync("cargo", ["metadata", "--format-version", "1", "--no-deps"], { cwd: join(here, "..") });
const built = join(JSON.parse(metadata).target_directory, target, "wasm", "page_wasm.wasm");
execFileSync("cargo", ["build", "--quiet", "--package", "page-wasm", "--profile", "wasm", "--target", target], {
  cwd: join(here, ".."),
  stdio: "inherit",
});
mkdirSync(dist, { recursive: true });
copyFileSync(built, join(dist, "page.wasm"));
copyFileSync(join(here, "index.html"), join(dist, "index.html"));
copyFileSync(join(here, "style.css"), join(dist, "style.css"));
await build({
  entryPoints: [join(here, "src", "main.ts")],
  outfile: join(dist, "page.js"),
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  legalComments: "inline",
});
let total = 0;
for (const file of readdirSync(dist)) {
  const size = gzipSync(readFileSync(join(dist, file)), { level: 9 }).length / 1000;
  total += size;
  console.log(`${file.padEnd(12)} ${size.toFixed(1).padStart(6)} KB compressed`);
}
console.log(`${"together".padEnd(12)} ${total.toFixed(1).padStart(6)} KB, limit ${LIMIT_KB}`);
if (total > LIMIT_KB) process.exit(1);
