// What the page shows of an elbow: the axis of its hinge with its bar, in words and in the picture.

import {
  CylinderGeometry, DoubleSide, Group, LatheGeometry, Mesh, MeshLambertMaterial, type Object3D, Vector2, Vector3,
} from "three";
import type { Model, Value } from "./model.ts";
import { BLUE, INK, ORANGE } from "./shapes.ts";
import { words } from "./words.ts";

/** How far the axis is drawn to either side of the limb, mm. */
const REACH = 110;
const OLD_REACH = 140;
/** The bar is drawn so many times as large, as long as it stays within LARGEST, mm. */
const MAGNIFICATIONS = [200, 100, 50, 20, 10, 5, 2];
const LARGEST = 45;
const AXES = ["x", "y", "z"];

/** The numbers if all of them are there. */
function whole(numbers: (Value | null)[]): Value[] | null {
  return numbers.every((value) => value !== null) ? (numbers as Value[]) : null;
}

/** By how much a direction is uncertain in all, degrees. */
function directionSigma(three: Value[]): number {
  return (Math.hypot(...three.map(({ sigma }) => sigma)) * 180) / Math.PI;
}

/** The new axis beside the one in use, in both bodies. */
export function hingeTable(model: Model): string {
  const [fresh, live] = [whole(model.candidateHinge), whole(model.liveHinge)];
  const row = (name: string, k: number, digits: number) => {
    const [a, b] = [fresh?.[k] ?? null, live?.[k] ?? null];
    const change = a !== null && b !== null ? signed(a.value - b.value, digits) : "–";
    return `<tr><th scope="row">${name}</th><td>${shown(a, digits)}</td><td>${shown(b, digits)}</td><td>${change}</td></tr>`;
  };
  const bodies = words.hinge.bodies.map((body, index) =>
    `<tr><th scope="rowgroup" colspan="4">${body}</th></tr>`
    + AXES.map((axis, k) => row(`${words.hinge.direction} ${axis}`, 6 * index + k, 4)).join("")
    + AXES.map((axis, k) => row(`${words.hinge.point} ${axis}`, 6 * index + 3 + k, 2)).join("")).join("")
    + `<tr><th scope="rowgroup" colspan="4">${words.hinge.between}</th></tr>${row(words.hinge.along, 12, 2)}`;
  const best = fresh ?? live;
  const note = best === null ? words.centre.refused
    : words.hinge.directionKnown(directionSigma(best.slice(0, 3)), directionSigma(best.slice(6, 9)));
  const verified = model.verification === null ? "" : `<p class="verified">${words.centre.deviation}: `
    + `<strong>${Number(model.verification["deviation"]).toFixed(3)} mm</strong> (${words.centre.limit} `
    + `${Number(model.verification["limit"]).toFixed(3)})</p>`;
  return `<table class="hinge"><caption>${words.hinge.title}</caption><thead><tr><td></td><th scope="col">${words.centre.fresh}</th>`
    + `<th scope="col">${words.centre.live}</th><th scope="col">${words.centre.difference}</th></tr></thead>`
    + `<tbody>${bodies}</tbody></table><p class="small">± ${words.centre.standardDeviation}. ${note}</p>${verified}`;
}

/** The hinge to look at: a new one, beside the one in use, while it waits for a decision; else the one in use; null: the drawn. */
export function inPicture(model: Model, state: string): { numbers: Value[] | null; old: Value[] | null; note: string } {
  const [fresh, live] = [state === "Review" ? whole(model.candidateHinge) : null, whole(model.liveHinge)];
  const [numbers, old] = fresh === null ? [live, null] : [fresh, live];
  const note = numbers === null ? words.hinge.drawn : words.hinge.bar(magnification(numbers), old !== null);
  return { numbers, old, note };
}

/** How far the joint bends now. */
export function angleText({ angle }: Model): string {
  return angle === null ? words.hinge.noAngle : words.hinge.angle((angle.value * 180) / Math.PI, angle.sigma);
}

function shown(value: Value | null, digits: number): string {
  return value === null ? "–" : `${value.value.toFixed(digits)} <span class="sigma">± ${value.sigma.toFixed(digits)}</span>`;
}

function signed(value: number, digits: number): string {
  return `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(digits)}`;
}

/** 1σ of where the axis is, across it, so far from its point: by its place and by its direction, mm. */
function barAt(numbers: Value[], along: number): number {
  const place = Math.hypot(...numbers.slice(3, 6).map(({ sigma }) => sigma));
  const turn = Math.hypot(...numbers.slice(0, 3).map(({ sigma }) => sigma));
  return Math.hypot(place, turn * along);
}

/** How many times as large the bar is drawn. */
function magnification(numbers: Value[]): number {
  return MAGNIFICATIONS.find((factor) => factor * barAt(numbers, REACH) <= LARGEST) ?? 1;
}

/** A rod along y, to be laid along an axis. */
function rod(radius: number, reach: number, colour: number): Mesh {
  return new Mesh(new CylinderGeometry(radius, radius, 2 * reach, 10), new MeshLambertMaterial({ color: colour }));
}

function lay(shape: Object3D, axis: number[], point: number[]): void {
  shape.position.fromArray(point);
  shape.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), new Vector3().fromArray(axis).normalize());
}

/** The axis in the picture: a rod, and about it its bar; and the one in use beside a new one: a thin rod that is longer. */
export class AxisShape {
  readonly group = new Group();
  readonly old = new Group();

  /** At a point of the base, mm; `numbers` as the board shows them, null for an axis that is only drawn. */
  put(axis: number[], point: number[], numbers: Value[] | null, old: Value[] | null): void {
    this.old.clear();
    if (old !== null) {
      this.old.add(rod(1.5, OLD_REACH, INK));
      const values = old.map(({ value }) => value);
      lay(this.old, values.slice(0, 3), values.slice(3, 6));
    }
    this.group.clear();
    const colour = numbers === null ? ORANGE : BLUE;
    this.group.add(rod(2.5, REACH, colour));
    if (numbers !== null) {
      const factor = magnification(numbers);
      const profile = Array.from({ length: 21 }, (_, k) => {
        const along = (k / 10 - 1) * REACH;
        return new Vector2(Math.max(3, factor * barAt(numbers, along)), along);
      });
      this.group.add(new Mesh(
        new LatheGeometry(profile, 28),
        new MeshLambertMaterial({ color: BLUE, transparent: true, opacity: 0.35, side: DoubleSide }),
      ));
    }
    lay(this.group, axis, point);
  }
}
