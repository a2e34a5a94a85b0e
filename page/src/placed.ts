// Where the platform stands, and where its points are then.

import { Matrix4, Quaternion } from "three";
import type { Placed } from "./library.ts";

/** A machine whose lengths at home do not close has no arm to show. */
export const NOWHERE: Placed = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], origin: [0, 0, 200] };

/** A direction in {P} in the axes of {B}. */
export function rotate({ rotation: r }: Placed, [x, y, z]: number[]): number[] {
  return [0, 3, 6].map((row) => r[row]! * x! + r[row + 1]! * y! + r[row + 2]! * z!);
}

/** A point in {P}, in {B}. */
export function transform(placed: Placed, point: number[]): number[] {
  return rotate(placed, point).map((value, k) => value + placed.origin[k]!);
}

export function mean(list: number[][]): number[] {
  return [0, 1, 2].map((k) => list.reduce((sum, point) => sum + point[k]!, 0) / list.length);
}

export function matrix(placed: Placed): Matrix4 {
  const [a, b, c, d, e, f, g, h, i] = placed.rotation as [number, number, number, number, number, number, number, number, number];
  return new Matrix4().set(a, b, c, 0, d, e, f, 0, g, h, i, 0, 0, 0, 0, 1);
}

/** Part of the way from one place to another. */
export function between(from: Placed, to: Placed, share: number): Placed {
  const rotation = new Quaternion().setFromRotationMatrix(matrix(from));
  rotation.slerp(new Quaternion().setFromRotationMatrix(matrix(to)), share);
  const m = new Matrix4().makeRotationFromQuaternion(rotation).elements;
  return {
    rotation: [m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]],
    origin: from.origin.map((value, k) => value + share * (to.origin[k]! - value)),
  };
}

export function distance(a: Placed, b: Placed): number {
  return Math.max(...a.rotation.map((value, k) => Math.abs(value - b.rotation[k]!)));
}
