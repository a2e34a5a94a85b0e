// The arm in the machine, in three dimensions. Lengths are millimetres; z points from the base to the arm.

import {
  AmbientLight, BufferGeometry, CanvasTexture, CylinderGeometry, DirectionalLight, DoubleSide, Float32BufferAttribute,
  Group, Line, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshLambertMaterial,
  PerspectiveCamera, Quaternion, RingGeometry, Scene, SphereGeometry, Sprite, SpriteMaterial, SRGBColorSpace, Vector3, WebGLRenderer,
  WireframeGeometry, BoxGeometry, ConeGeometry, MeshBasicMaterial,
} from "three";
import type { Identification, Machine, Placed } from "./library.ts";
import { words } from "./words.ts";

/** Cable k runs from end-point ATTACHMENTS[k][0] to base point ATTACHMENTS[k][1]. */
const ATTACHMENTS = [[0, 0], [0, 1], [1, 1], [1, 2], [2, 2], [2, 0]] as const;
/** Radius of the sphere of directions, mm. */
const SPHERE = 190;
const ARM = 300;
/** Error ellipsoids are far smaller than the arm. */
export const MAGNIFIED = 200;

const INK = 0x16202a;
const BLUE = 0x1769aa;
const ORANGE = 0xd55e00;
const GREEN = 0x00795c;
const GREY = 0x8a96a3;

export class ArmScene {
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(38, 1, 10, 5000);
  private readonly renderer: WebGLRenderer;
  private readonly cables: { mesh: Mesh; text: Sprite }[] = [];
  private readonly cuff: Mesh[];
  private readonly arm: Mesh;
  private readonly centre: Group = new Group();
  private readonly ellipsoid: Mesh;
  private readonly old: Group;
  private readonly directions = new Group();
  private readonly path = new Group();
  private readonly next: Group;
  private readonly nextLabel: Sprite;
  private turn = 0.6;
  private lift = 0.35;
  private distance = 950;
  /** Where the platform is drawn, and where it goes. */
  private shown: Placed;
  private target: Placed;
  private dirty = true;
  frames = 0;

  constructor(canvas: HTMLCanvasElement, private readonly machine: Machine, home: Placed) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.shown = home;
    this.target = home;
    this.scene.add(new AmbientLight(0xffffff, 1.6));
    const lamp = new DirectionalLight(0xffffff, 1.8);
    lamp.position.set(400, -600, 900);
    this.scene.add(lamp);
    this.scene.add(this.base());
    for (let cable = 0; cable < 6; cable += 1) {
      const mesh = rod(2.2, INK);
      const text = label(`L${cable + 1}`);
      this.cables.push({ mesh, text });
      this.scene.add(mesh, text);
    }
    this.cuff = [0, 1, 2].map(() => rod(4, BLUE));
    this.scene.add(...this.cuff);
    this.arm = new Mesh(
      new CylinderGeometry(26, 34, ARM, 20).rotateX(Math.PI / 2).translate(0, 0, ARM / 2 + 20),
      new MeshLambertMaterial({ color: 0xd9a37f, transparent: true, opacity: 0.55 }),
    );
    this.scene.add(this.arm);
    this.centre.add(new Mesh(new SphereGeometry(5, 16, 12), new MeshLambertMaterial({ color: BLUE })));
    this.ellipsoid = new Mesh(
      new SphereGeometry(1, 24, 16),
      new MeshLambertMaterial({ color: BLUE, transparent: true, opacity: 0.35 }),
    );
    this.ellipsoid.matrixAutoUpdate = false;
    this.scene.add(this.centre, this.ellipsoid, this.path);
    this.old = cross();
    this.scene.add(this.old, this.directions);
    this.next = target();
    this.nextLabel = label(words.scene.goThere);
    this.nextLabel.position.set(0, 0, SPHERE + 30);
    this.next.add(this.nextLabel);
    this.scene.add(this.next);
    this.old.visible = this.next.visible = this.ellipsoid.visible = false;
    this.steer(canvas);
    this.put(home);
  }

  /** The arm goes there, not at once. */
  moveTo(placed: Placed): void {
    this.target = placed;
    this.dirty = true;
  }

  /** The arm is there: many times a second. */
  follow(placed: Placed): void {
    this.target = placed;
    if (distance(this.shown, placed) > 1e-4) {
      this.put(placed);
      this.dirty = true;
    }
  }

  /** The new centre (or the nominal one), the one in use, what the poses say. */
  show(found: Identification | null, live: number[] | null): void {
    const centre = found?.centre ?? live ?? this.machine.nominal;
    this.centre.position.fromArray(centre);
    this.old.visible = live !== null && found?.centre != null;
    if (live !== null) this.old.position.fromArray(live);
    this.ellipsoid.visible = found?.centre != null && found.covariance !== undefined;
    if (found?.covariance !== undefined && found.centre !== null) {
      this.ellipsoid.matrix.copy(ellipsoid(found.covariance, found.centre));
    }
    this.coverage(found, centre);
    this.dirty = true;
  }

  /** Draws what has changed; true while something moves. */
  frame(): boolean {
    this.fit();
    const moving = distance(this.shown, this.target) > 1e-3;
    if (moving) {
      this.put(between(this.shown, this.target, 0.18));
      this.dirty = true;
    }
    if (this.dirty) {
      this.dirty = false;
      const [turn, lift] = [this.turn, this.lift];
      this.camera.up.set(0, 0, 1);
      this.camera.position.set(
        Math.cos(turn) * Math.cos(lift), Math.sin(turn) * Math.cos(lift), Math.sin(lift),
      ).multiplyScalar(this.distance).add(new Vector3(0, 0, 190));
      this.camera.lookAt(0, 0, 190);
      this.renderer.render(this.scene, this.camera);
      this.frames += 1;
    }
    return moving;
  }

  private base(): Group {
    const group = new Group();
    const corners = this.machine.base;
    corners.forEach((corner, index) => {
      const side = rod(4, GREY);
      span(side, corner, corners[(index + 1) % 3]!);
      group.add(side);
    });
    corners.forEach((corner, index) => {
      const box = new Mesh(new BoxGeometry(16, 16, 16), new MeshLambertMaterial({ color: GREY }));
      box.position.fromArray(corner);
      const text = label(`B${index + 1}`);
      text.position.set(corner[0]! * 1.22, corner[1]! * 1.22, corner[2]!);
      group.add(box, text);
    });
    return group;
  }

  private put(placed: Placed): void {
    this.shown = placed;
    const ends = this.machine.platform.map((point) => transform(placed, point));
    ATTACHMENTS.forEach(([end, base], cable) => {
      const { mesh, text } = this.cables[cable]!;
      const [from, to] = [this.machine.base[base]!, ends[end]!];
      span(mesh, from, to);
      // two cables leave each base point: their names stand at different heights
      const share = cable % 2 === 0 ? 0.36 : 0.5;
      text.position.fromArray(from.map((value, k) => value + share * (to[k]! - value)));
    });
    this.cuff.forEach((mesh, side) => span(mesh, ends[side]!, ends[(side + 1) % 3]!));
    // the arm goes from the joint through the middle of the cuff
    const axis = armAxis(placed);
    const middle = [0, 1, 2].map((k) => (ends[0]![k]! + ends[1]![k]! + ends[2]![k]!) / 3);
    this.arm.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3().fromArray(axis));
    this.arm.position.fromArray(middle.map((value, k) => value - 96 * axis[k]!));
  }

  /** Directions of the arm that the poses cover, and the one to go to. */
  private coverage(found: Identification | null, centre: number[]): void {
    this.directions.clear();
    this.path.clear();
    const wire = new LineSegments(
      new WireframeGeometry(new SphereGeometry(SPHERE, 24, 9, 0, 2 * Math.PI, 0, Math.PI / 2).rotateX(Math.PI / 2)),
      new LineBasicMaterial({ color: GREY, transparent: true, opacity: 0.25 }),
    );
    this.directions.add(wire);
    this.directions.position.fromArray(centre);
    const rejected = new Set((found?.rejected ?? []).map(([pose]) => pose));
    found?.poses.forEach((pose, index) => {
      if (pose === null) return;
      const axis = armAxis(pose);
      // a pose that was left out is a hollow ring
      const mark = rejected.has(index)
        ? new Mesh(new RingGeometry(5, 9, 20), new MeshBasicMaterial({ color: ORANGE, side: DoubleSide }))
        : new Mesh(new SphereGeometry(7, 12, 10), new MeshLambertMaterial({ color: GREEN }));
      mark.position.fromArray(axis).multiplyScalar(SPHERE);
      mark.lookAt(mark.position.clone().multiplyScalar(2).add(this.directions.position));
      this.directions.add(mark);
      if (pose.centre !== undefined && found.centre !== null) {
        const dot = new Mesh(new SphereGeometry(2, 8, 6), new MeshBasicMaterial({ color: ORANGE }));
        // the centre that this pose alone shows
        dot.position.fromArray(apart(pose.centre, found.centre));
        this.path.add(dot);
      }
      if (found.moving === true && pose.path !== undefined && found.centre !== null) {
        const dot = new Mesh(new BoxGeometry(5, 5, 5), new MeshBasicMaterial({ color: BLUE }));
        dot.position.fromArray(apart(pose.path, found.centre));
        this.path.add(dot);
      }
    });
    const next = found?.next ?? null;
    this.next.visible = next !== null;
    if (next !== null) {
      this.next.position.fromArray(centre);
      this.next.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3().fromArray(next.axis));
    }
  }

  setNextVisible(visible: boolean): void {
    if (!visible && this.next.visible) {
      this.next.visible = false;
      this.dirty = true;
    }
  }

  private fit(): void {
    const canvas = this.renderer.domElement;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const ratio = Math.min(window.devicePixelRatio, 2);
    if (canvas.width !== Math.floor(width * ratio) || canvas.height !== Math.floor(height * ratio)) {
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / Math.max(height, 1);
      this.camera.updateProjectionMatrix();
      this.dirty = true;
    }
  }

  /** Pointer, wheel and arrow keys turn the view. */
  private steer(canvas: HTMLCanvasElement): void {
    const turnBy = (turn: number, lift: number) => {
      this.turn -= turn;
      this.lift = Math.min(1.5, Math.max(-0.3, this.lift + lift));
      this.dirty = true;
    };
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons !== 0) turnBy(event.movementX * 0.008, event.movementY * 0.008);
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.distance = Math.min(2500, Math.max(400, this.distance * Math.exp(event.deltaY * 0.001)));
      this.dirty = true;
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.08], ArrowDown: [0, -0.08] }[event.key];
      if (step === undefined) return;
      event.preventDefault();
      turnBy(step[0]!, step[1]!);
    });
  }
}

/** Direction of the arm in {B}: the normal of the cuff. */
export function armAxis(placed: Placed): number[] {
  return [placed.rotation[2]!, placed.rotation[5]!, placed.rotation[8]!];
}

function transform(placed: Placed, point: number[]): number[] {
  const { rotation: r, origin } = placed;
  return [0, 1, 2].map((row) =>
    origin[row]! + r[3 * row]! * point[0]! + r[3 * row + 1]! * point[1]! + r[3 * row + 2]! * point[2]!);
}

function matrix(placed: Placed): Matrix4 {
  const [a, b, c, d, e, f, g, h, i] = placed.rotation as [number, number, number, number, number, number, number, number, number];
  return new Matrix4().set(a, b, c, 0, d, e, f, 0, g, h, i, 0, 0, 0, 0, 1);
}

/** Part of the way from one place to another. */
function between(from: Placed, to: Placed, share: number): Placed {
  const rotation = new Quaternion().setFromRotationMatrix(matrix(from));
  rotation.slerp(new Quaternion().setFromRotationMatrix(matrix(to)), share);
  const m = new Matrix4().makeRotationFromQuaternion(rotation).elements;
  return {
    rotation: [m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]],
    origin: from.origin.map((value, k) => value + share * (to.origin[k]! - value)),
  };
}

function distance(a: Placed, b: Placed): number {
  return Math.max(...a.rotation.map((value, k) => Math.abs(value - b.rotation[k]!)));
}

/** A thin cylinder of length one; `span` puts it between two points. */
function rod(radius: number, colour: number): Mesh {
  const geometry = new CylinderGeometry(radius, radius, 1, 8).rotateX(Math.PI / 2).translate(0, 0, 0.5);
  return new Mesh(geometry, new MeshLambertMaterial({ color: colour }));
}

function span(mesh: Mesh, from: number[], to: number[]): void {
  mesh.position.fromArray(from);
  mesh.lookAt(new Vector3().fromArray(to));
  mesh.scale.set(1, 1, new Vector3().fromArray(from).distanceTo(new Vector3().fromArray(to)));
}

function positions(list: number[][]): Float32BufferAttribute {
  return new Float32BufferAttribute(list.flat(), 3);
}

function points(list: number[][]): BufferGeometry {
  return new BufferGeometry().setAttribute("position", positions(list));
}

/** The one-sigma ellipsoid of a covariance (lower triangle): a sphere under its Cholesky factor. */
function ellipsoid([xx, yx, yy, zx, zy, zz]: number[], centre: number[]): Matrix4 {
  const a = Math.sqrt(xx!);
  const b = yx! / a;
  const c = Math.sqrt(Math.max(yy! - b * b, 0));
  const d = zx! / a;
  const e = c > 0 ? (zy! - d * b) / c : 0;
  const f = Math.sqrt(Math.max(zz! - d * d - e * e, 0));
  const m = MAGNIFIED;
  return new Matrix4().set(
    a * m, 0, 0, centre[0]!, b * m, c * m, 0, centre[1]!, d * m, e * m, f * m, centre[2]!, 0, 0, 0, 1,
  );
}

/** Ten times as far from the common centre, so that millimetres are seen. */
function apart(centre: number[], common: number[]): number[] {
  return centre.map((value, k) => common[k]! + 10 * (value - common[k]!));
}

function cross(): Group {
  const group = new Group();
  for (const axis of [[14, 0, 0], [0, 14, 0], [0, 0, 14]]) {
    group.add(new Line(points([axis.map((v) => -v), axis]), new LineBasicMaterial({ color: ORANGE })));
  }
  return group;
}

function target(): Group {
  const group = new Group();
  const cone = new Mesh(new ConeGeometry(12, 30, 4), new MeshLambertMaterial({ color: ORANGE }));
  cone.rotation.x = -Math.PI / 2;
  cone.position.set(0, 0, SPHERE + 16);
  const ring = new Mesh(new RingGeometry(16, 21, 28), new MeshBasicMaterial({ color: ORANGE, side: DoubleSide }));
  ring.position.set(0, 0, SPHERE);
  group.add(cone, ring, new Line(points([[0, 0, 0], [0, 0, SPHERE]]), new LineBasicMaterial({ color: ORANGE })));
  return group;
}

function label(text: string): Sprite {
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
