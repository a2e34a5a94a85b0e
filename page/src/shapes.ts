// The shapes that the picture is made of. Lengths are millimetres on the shoulder's machine.

import {
  BufferGeometry, CanvasTexture, ConeGeometry, CylinderGeometry, DoubleSide, Float32BufferAttribute, Group, Line,
  LineBasicMaterial, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, RingGeometry, Sprite, SpriteMaterial,
  SRGBColorSpace, Vector3,
} from "three";

export const INK = 0x16202a;
export const BLUE = 0x1769aa;
export const ORANGE = 0xd55e00;
export const GREEN = 0x00795c;
export const GREY = 0x8a96a3;

/** Radius of the sphere of directions. */
export const SPHERE = 190;
/** Error ellipsoids are far smaller than the arm: so many times as large they are drawn, as long as they stay within LARGEST. */
const MAGNIFICATIONS = [200, 100, 50, 20, 10, 5, 2];
const LARGEST = 60;

/** How many times as large an ellipsoid of this covariance (lower triangle, mm²) is drawn. */
export function magnification([xx, , yy, , , zz]: number[]): number {
  const sigma = Math.sqrt(Math.max(xx!, yy!, zz!));
  return MAGNIFICATIONS.find((factor) => factor * sigma <= LARGEST) ?? 1;
}

/** A thin cylinder of length one; `span` puts it between two points. */
export function rod(radius: number, colour: number): Mesh {
  const geometry = new CylinderGeometry(radius, radius, 1, 8).rotateX(Math.PI / 2).translate(0, 0, 0.5);
  return new Mesh(geometry, new MeshLambertMaterial({ color: colour }));
}

export function span(mesh: Mesh, from: number[], to: number[], thickness = 1): void {
  mesh.position.fromArray(from);
  mesh.lookAt(new Vector3().fromArray(to));
  mesh.scale.set(thickness, thickness, new Vector3().fromArray(from).distanceTo(new Vector3().fromArray(to)));
}

export function positions(list: number[][]): Float32BufferAttribute {
  return new Float32BufferAttribute(list.flat(), 3);
}

export function points(list: number[][]): BufferGeometry {
  return new BufferGeometry().setAttribute("position", positions(list));
}

/** The one-sigma ellipsoid of a covariance (lower triangle): a sphere under its Cholesky factor. */
export function ellipsoid([xx, yx, yy, zx, zy, zz]: number[], centre: number[]): Matrix4 {
  const a = Math.sqrt(xx!);
  const b = yx! / a;
  const c = Math.sqrt(Math.max(yy! - b * b, 0));
  const d = zx! / a;
  const e = c > 0 ? (zy! - d * b) / c : 0;
  const f = Math.sqrt(Math.max(zz! - d * d - e * e, 0));
  const m = magnification([xx!, yx!, yy!, zx!, zy!, zz!]);
  return new Matrix4().set(
    a * m, 0, 0, centre[0]!, b * m, c * m, 0, centre[1]!, d * m, e * m, f * m, centre[2]!, 0, 0, 0, 1,
  );
}

/** Ten times as far from the common centre, so that millimetres are seen. */
export function apart(centre: number[], common: number[]): number[] {
  return centre.map((value, k) => common[k]! + 10 * (value - common[k]!));
}

export function cross(): Group {
  const group = new Group();
  for (const axis of [[14, 0, 0], [0, 14, 0], [0, 0, 14]]) {
    group.add(new Line(points([axis.map((v) => -v), axis]), new LineBasicMaterial({ color: ORANGE })));
  }
  return group;
}

export function target(): Group {
  const group = new Group();
  const cone = new Mesh(new ConeGeometry(12, 30, 4), new MeshLambertMaterial({ color: ORANGE }));
  cone.rotation.x = -Math.PI / 2;
  cone.position.set(0, 0, SPHERE + 16);
  const ring = new Mesh(new RingGeometry(16, 21, 28), new MeshBasicMaterial({ color: ORANGE, side: DoubleSide }));
  ring.position.set(0, 0, SPHERE);
  group.add(cone, ring, new Line(points([[0, 0, 0], [0, 0, SPHERE]]), new LineBasicMaterial({ color: ORANGE })));
  return group;
}

export function label(text: string): Sprite {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d")!;
  context.font = "bold 44px sans-serif";
  canvas.width = Math.ceil(context.measureText(text).width) + 16;
  canvas.height = 60;
  context.font = "bold 44px sans-serif";
  context.textBaseline = "middle";
  context.fillStyle = "#16202a";
  context.fillText(text, 8, 31);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  const sprite = new Sprite(new SpriteMaterial({ map: texture, depthTest: false }));
  sprite.scale.set(canvas.width * 0.5, canvas.height * 0.5, 1);
  return sprite;
}
