// Two small charts as SVG: the standard deviation against the poses, and what each pose and cable leaves.

import type { Identification } from "./library.ts";
import { words } from "./words.ts";

const WIDTH = 460;
const HEIGHT = 190;
const LEFT = 56;
const BOTTOM = 30;

/** The procedure's own target, mm. */
const TARGET_MM = 0.05;

export function accuracyChart(sigmas: (number | null)[]): string {
  const known = sigmas.map((sigma, index) => ({ sigma, index })).filter((point) => point.sigma !== null) as
    { sigma: number; index: number }[];
  const columns = Math.max(12, sigmas.length);
  const [low, high] = [0.01, 10];
  const x = (index: number) => LEFT + ((index + 0.5) / columns) * (WIDTH - LEFT - 10);
  const y = (sigma: number) => {
    const share = Math.log(Math.min(high, Math.max(low, sigma)) / low) / Math.log(high / low);
    return HEIGHT - BOTTOM - share * (HEIGHT - BOTTOM - 12);
  };
  const grid = [0.01, 0.1, 1, 10].map((value) =>
    `<line x1="${LEFT}" x2="${WIDTH - 10}" y1="${y(value)}" y2="${y(value)}" class="grid"/>`
    + `<text x="${LEFT - 8}" y="${y(value) + 5}" text-anchor="end">${value}</text>`).join("");
  const ticks = Array.from({ length: columns }, (_, index) => index + 1).filter((n) => n % Math.ceil(columns / 8) === 0)
    .map((n) => `<text x="${x(n - 1)}" y="${HEIGHT - 8}" text-anchor="middle">${n}</text>`).join("");
  const line = known.map((point) => `${x(point.index).toFixed(1)},${y(point.sigma).toFixed(1)}`).join(" ");
  const dots = known.map((point) => `<circle cx="${x(point.index)}" cy="${y(point.sigma)}" r="5"/>`).join("");
  const last = known.at(-1);
  const now = last === undefined ? "" : ` ${last.sigma.toFixed(3)}`;
  return svg(`${words.accuracy.title}:${now}`, grid + ticks
    + `<line x1="${LEFT}" x2="${WIDTH - 10}" y1="${y(TARGET_MM)}" y2="${y(TARGET_MM)}" class="target"/>`
    + `<text x="${WIDTH - 12}" y="${y(TARGET_MM) - 6}" text-anchor="end">${words.accuracy.target}</text>`
    + `<polyline points="${line}" class="line"/>${dots}`
    + `<text x="${LEFT - 8}" y="${HEIGHT - 8}" text-anchor="end">${words.accuracy.poses}</text>`);
}

/** A square for each pose and cable: its size is what is left, filled when too long, hollow when too short. */
export function residualChart(found: Identification | null): string {
  const poses = found?.poses ?? [];
  const any = poses.some((pose) => pose?.residuals !== undefined);
  if (!any) return svg(words.residuals.title, `<text x="${LEFT}" y="60">${words.residuals.none}</text>`);
  const rejected = new Map(found?.rejected ?? []);
  const cell = Math.min(30, (WIDTH - LEFT - 10) / poses.length);
  const row = (HEIGHT - BOTTOM - 10) / 6;
  const largest = Math.max(0.15, ...poses.flatMap((pose) => (pose?.residuals ?? []).map(Math.abs)));
  let marks = "";
  for (let cable = 0; cable < 6; cable += 1) {
    marks += `<text x="${LEFT - 8}" y="${10 + (cable + 0.5) * row + 5}" text-anchor="end">L${cable + 1}</text>`;
  }
  poses.forEach((pose, index) => {
    const x = LEFT + (index + 0.5) * cell;
    (pose?.residuals ?? []).forEach((left, cable) => {
      const half = Math.max(1, (Math.min(cell, row) / 2 - 1) * Math.sqrt(Math.abs(left) / largest));
      const y = 10 + (cable + 0.5) * row;
      const kind = left > 0 ? "long" : "short";
      marks += `<rect x="${x - half}" y="${y - half}" width="${2 * half}" height="${2 * half}" class="${kind}">`
        + `<title>${words.residuals.pose} ${index + 1}, L${cable + 1}: ${left.toFixed(3)} mm</title></rect>`;
    });
    if (rejected.has(index)) {
      marks += `<rect x="${x - cell / 2}" y="6" width="${cell}" height="${HEIGHT - BOTTOM}" class="out">`
        + `<title>${words.residuals.leftOut}</title></rect>`;
    }
  });
  return svg(`${words.residuals.title} (±${largest.toFixed(2)}; ${words.residuals.legend})`, marks);
}

function svg(title: string, content: string): string {
  return `<figure><figcaption>${title}</figcaption>`
    + `<svg viewBox="0 0 ${WIDTH} ${HEIGHT}" role="img" aria-label="${title}">${content}</svg></figure>`;
}
