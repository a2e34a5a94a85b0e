// The texts beside the picture: what to do, the centre, the decision, faults, the board.

import type { Identification, Library } from "./library.ts";
import type { Model, Value } from "./model.ts";
import { words } from "./words.ts";

/** May the centre in use be used? As in the DBC. */
export const UNCONFIRMED = 2;
const NOT_TO_BE_USED = 3;

/** What the library says of a code after which there is nothing to do. */
const NO_REMEDY = "none";
const AXES = ["x", "y", "z"];

export function element<T extends HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`the page has no ${id}`);
  return found as T;
}

/** Writes only what is different, so that a screen reader is not disturbed. */
export function write(id: string, html: string): void {
  const target = element(id);
  if (target.dataset["html"] !== html) {
    target.dataset["html"] = html;
    target.innerHTML = html;
  }
}

export interface Situation {
  connected: boolean;
  silent: boolean;
  recording: boolean;
  complaint: string;
}

/** The large words: what the person at the arm should do now, and why. */
export function guidance(model: Model, library: Library, situation: Situation): { text: string; detail: string } {
  if (situation.complaint !== "") return { text: situation.complaint, detail: "" };
  if (!situation.connected) return { text: words.guidance.noSource, detail: "" };
  const heartbeat = model.heartbeat;
  if (situation.silent) return { text: words.guidance.silent, detail: words.guidance.silentRemedy };
  if (heartbeat === null) return { text: words.guidance.connecting, detail: "" };
  const outcome = model.outcome === null ? null : explained(model, library, model.outcome["reason"]);
  const state = library.state(Number(heartbeat["state"]));
  if (state === "Failed" || (state === "Idle" && outcome !== null && outcome.name !== "Fine")) {
    if (outcome?.name === "Accepted") return { text: model.isHinge ? words.hinge.accepted : words.guidance.accepted, detail: "" };
    const reason = outcome ?? explained(model, library, heartbeat["reason"]);
    return { text: reason.text, detail: reason.remedy };
  }
  if (state === "Idle") {
    const standing = Number(heartbeat["standing"]);
    const unconfirmed = model.isHinge ? words.hinge.unconfirmed : words.guidance.unconfirmed;
    if (standing === UNCONFIRMED) return { text: unconfirmed, detail: words.guidance.unconfirmedRemedy };
    const reason = explained(model, library, heartbeat["reason"]);
    if (reason.name !== "Fine") return { text: reason.text, detail: reason.remedy };
    const notToBeUsed = model.isHinge ? words.hinge.notToBeUsed : words.guidance.notToBeUsed;
    if (standing === NOT_TO_BE_USED) return { text: notToBeUsed, detail: "" };
    const idle = model.isHinge ? words.hinge.idleWithAxis : words.guidance.idleWithCentre;
    const text = Number(heartbeat["live"]) === 1 ? idle : words.guidance.idle;
    return { text: situation.recording ? words.guidance.recording : text, detail: "" };
  }
  const reason = explained(model, library, heartbeat["reason"]);
  const detail = reason.name === "Fine" ? "" : `${reason.text} ${reason.remedy}`;
  const advice = Number(heartbeat["guidance"]);
  const ofHinge = model.isHinge ? words.hinge.guidance[library.guidanceName(advice)] : undefined;
  return { text: ofHinge ?? ofJoint(model, library.guidance(advice)), detail };
}

/** What a code says and what to do about it, in sentences; of a hinge they speak of its axis. */
export function explained(model: Model, library: Library, code: unknown): { name: string; text: string; remedy: string } {
  const { name, text, remedy } = library.reason(Number(code));
  return { name, text: ofJoint(model, text), remedy: remedy === NO_REMEDY ? "" : ofJoint(model, remedy) };
}

function ofJoint({ isHinge }: Model, text: string): string {
  return sentence(isHinge ? words.hinge.ofAxis(text) : text);
}

/** A sentence from the library's words. */
export function sentence(text: string): string {
  return text === "" ? "" : `${text[0]!.toUpperCase()}${text.slice(1)}.`;
}

export function stateLine(model: Model, library: Library): string {
  const heartbeat = model.heartbeat;
  if (heartbeat === null) return "";
  const name = library.state(Number(heartbeat["state"]));
  const state = (model.isHinge ? words.hinge.states[name] : undefined) ?? words.states[name] ?? "";
  const [first, second] = [model.whole(false).length, model.whole(true).length];
  const poses = first + second > 0 ? ` · ${words.poses(first + second, second)}` : "";
  const run = model.run > 0 ? ` · run ${model.run}` : "";
  return `${state}${poses}${run}`;
}

/** The new centre beside the one in use. */
export function centreTable(model: Model, found: Identification | null): string {
  const reported = model.candidate.every((value) => value !== null);
  const fresh: (Value | null)[] = reported
    ? model.candidate
    : [0, 1, 2].map((k) =>
        found?.centre == null ? null : { value: found.centre[k]!, sigma: found.sigma?.[k] ?? NaN });
  const rows = AXES.map((axis, k) => {
    const [a, b] = [fresh[k] ?? null, model.live[k] ?? null];
    const change = a !== null && b !== null ? signed(a.value - b.value) : "–";
    return `<tr><th scope="row">${axis}</th><td>${shown(a)}</td><td>${shown(b)}</td><td>${change}</td></tr>`;
  }).join("");
  const note = reported ? words.centre.standardDeviation
    : found?.centre == null ? words.centre.refused : words.centre.computed;
  const verified = model.verification === null ? "" : `<p class="verified">${words.centre.deviation}: `
    + `<strong>${number(model.verification["deviation"])} mm</strong> (${words.centre.limit} `
    + `${number(model.verification["limit"])})</p>`;
  return `<table><caption>${words.centre.title}</caption><thead><tr><td></td><th scope="col">${words.centre.fresh}</th>`
    + `<th scope="col">${words.centre.live}</th><th scope="col">${words.centre.difference}</th></tr></thead>`
    + `<tbody>${rows}</tbody></table><p class="small">± ${note}</p>${verified}`;
}

function shown(value: Value | null): string {
  return value === null ? "–" : `${value.value.toFixed(2)} <span class="sigma">± ${value.sigma.toFixed(3)}</span>`;
}

function signed(value: number): string {
  return `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(2)}`;
}

function number(value: unknown): string {
  return Number(value).toFixed(3);
}

export function faultList(model: Model, library: Library): string {
  const faults = [...model.faults.values()].filter((fault) => fault.active);
  if (faults.length === 0) return `<p class="small">${words.faults.none}</p>`;
  return `<ul>${faults.map((fault) => {
    const { text, remedy } = explained(model, library, fault.code);
    const cable = fault.cable > 0 ? ` (${words.faults.cable} ${fault.cable})` : "";
    return `<li><strong>${text}${cable}</strong> ${remedy}</li>`;
  }).join("")}</ul>`;
}

export function boardList(model: Model): string {
  const versions = model.versions;
  if (versions === null) return "";
  const rows: [string, string][] = [
    [words.board.firmware, `${versions["major"]}.${versions["minor"]}.${versions["patch"]}`],
    [words.board.protocol, String(versions["protocol"])],
    [words.board.rig, Number(versions["rig"]).toString(16).padStart(4, "0")],
    [words.board.capacity, String(versions["capacity"])],
    [words.board.sequence, String(model.heartbeat?.["sequence"] ?? "–")],
  ];
  return `<dl>${rows.map(([term, value]) => `<div><dt>${term}</dt><dd>${value}</dd></div>`).join("")}</dl>`;
}
