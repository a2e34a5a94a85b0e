// The arm in the machine, in three dimensions. Lengths are millimetres; z points from the base to the arm.

import {
  AmbientLight, BoxGeometry, CylinderGeometry, DirectionalLight, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, MeshLambertMaterial, PerspectiveCamera, RingGeometry, Scene, SphereGeometry, type Sprite, Vector3,
  WebGLRenderer, WireframeGeometry,
} from "three";
import { AxisShape } from "./hinge.ts";
import type { Identification, Machine, Placed } from "./library.ts";
import type { Value } from "./model.ts";
import { between, distance, mean, NOWHERE, rotate, transform } from "./placed.ts";
import { apart, BLUE, cross, ellipsoid, GREEN, GREY, INK, label, ORANGE, rod, span, SPHERE, target } from "./shapes.ts";
import { words } from "./words.ts";

/** The shoulder's base, mm: every size below is for it, and in proportion for other machines. */
const BASE_RADIUS = 150;
const ARM = 300;
/** Height that the view looks at. */
const MIDDLE = 190;
const CABLE_RADIUS = 2.2;
/** So much thicker is a cable that is to be found. */
const MARKED = 2.5;

export class ArmScene {
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(38, 1, 10, 5000);
  private readonly renderer: WebGLRenderer;
  private readonly cables: { mesh: Mesh; text: Sprite }[] = [];
  private readonly cuff: Mesh[];
  private readonly hinge = new AxisShape();
  private readonly arm: Mesh;
  private readonly centre: Group = new Group();
  private readonly ellipsoid: Mesh;
  private readonly old: Group;
  private readonly directions = new Group();
  private readonly baseGroup = new Group();
  private readonly path = new Group();
  private readonly next: Group;
  private readonly nextLabel: Sprite;
  private turn = 0.6;
  private lift = 0.35;
  private distance = 950;
  /** Where the platform is drawn, and where it goes. */
  private shown = NOWHERE;
  private target = NOWHERE;
  private dirty = true;
  private marked: number | null = null;
  /** The centre that is shown is a new one. */
  private isNew = false;
  private machine: Machine;
  /** Size of the machine beside the shoulder. */
  private size = 1;
  /** The arm's direction in {P}, and how far the cuff's middle stands from the joint, mm. */
  private axis = [0, 0, 1];
  private cuffAt = 96;
  frames = 0;

  constructor(canvas: HTMLCanvasElement, machine: Machine) {
    this.machine = machine;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.scene.add(new AmbientLight(0xffffff, 1.6));
    const lamp = new DirectionalLight(0xffffff, 1.8);
    lamp.position.set(400, -600, 900);
    this.scene.add(lamp);
    this.scene.add(this.baseGroup);
    for (let cable = 0; cable < 6; cable += 1) {
      const mesh = rod(CABLE_RADIUS, INK);
      const text = label(`L${cable + 1}`);
      this.cables.push({ mesh, text });
      this.scene.add(mesh, text);
    }
    this.cuff = [0, 1, 2, 3].map(() => rod(4, BLUE));
    this.scene.add(...this.cuff, this.hinge.group, this.hinge.old);
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
    this.setMachine(machine);
  }

  /** Another machine than the one so far: its sizes, its base, the arm at home. */
  setMachine(machine: Machine): void {
    this.machine = machine;
    // an elbow is long and slender: the view is of its axis
    this.size = machine.joint === "hinge" ? Math.hypot(...machine.nominal) / MIDDLE
      : Math.max(...machine.base.map((point) => Math.hypot(...point))) / BASE_RADIUS;
    const home = machine.home ?? NOWHERE;
    const isHinge = machine.joint === "hinge";
    this.axis = isHinge ? this.forearm() : this.upperArm(home);
    const middle = mean(machine.platform.map((point) => transform(home, point)));
    this.cuffAt = isHinge ? Math.hypot(...mean(machine.platform).map((value, k) => value - machine.pivot![k]!))
      : Math.hypot(...middle.map((value, k) => value - machine.nominal[k]!));
    this.cables.forEach(({ mesh, text }, cable) => {
      mesh.visible = text.visible = cable < machine.base.length;
    });
    this.cuff.forEach((side, index) => {
      side.visible = index < machine.platform.length;
    });
    this.hinge.group.visible = this.hinge.old.visible = isHinge;
    for (const shape of [this.centre, this.directions, this.path, this.ellipsoid]) shape.visible = !isHinge;
    if (isHinge) this.showHinge(null);
    this.baseGroup.clear();
    this.drawBase();
    for (const group of [this.directions, this.next, this.arm]) group.scale.setScalar(this.size);
    this.target = home;
    this.put(home);
    this.dirty = true;
  }

  /** The arm's direction in {P}: across the cuff, away from the base. */
  private upperArm(home: Placed): number[] {
    const [a, b, c] = this.machine.platform.map((point) => new Vector3().fromArray(point)) as [Vector3, Vector3, Vector3];
    const normal = b.clone().sub(a).cross(c.clone().sub(a)).normalize();
    // from the joint to the cuff
    if (rotate(home, normal.toArray())[2]! < 0) normal.negate();
    return normal.toArray();
  }

  /** The same of a forearm: from its point of the axis to the middle of its ring. */
  private forearm(): number[] {
    const pivot = new Vector3().fromArray(this.machine.pivot!);
    return new Vector3().fromArray(mean(this.machine.platform)).sub(pivot).normalize().toArray();
  }

  /** The axis of a hinge where the machine has it, with its bar; null: it is only drawn. Beside a new one the one in use. */
  showHinge(numbers: Value[] | null, old: Value[] | null = null): void {
    this.hinge.put(this.machine.axis!, this.machine.nominal, numbers, old);
    this.dirty = true;
  }

  /** Makes one cable, from 0, stand out; none for null. */
  mark(cable: number | null): void {
    this.cables.forEach(({ mesh }, index) => {
      const marked = index === cable;
      (mesh.material as MeshLambertMaterial).color.set(marked ? ORANGE : INK);
      mesh.scale.x = mesh.scale.y = marked ? MARKED : 1;
    });
    this.marked = cable;
    this.dirty = true;
  }

  /** The arm goes there, not at once. */
  moveTo(placed: Placed): void {
    this.target = placed;
    this.dirty = true;
  }

  /** The arm is there, and the centre in use with it: many times a second. */
  follow(placed: Placed, centre: number[] | null): void {
    this.target = placed;
    if (centre !== null && !this.isNew) this.centre.position.fromArray(centre);
    if (distance(this.shown, placed) > 1e-4) {
      this.put(placed);
      this.dirty = true;
    }
  }

  /** The new centre (or the nominal one), the one in use, what the poses say. */
  show(found: Identification | null, live: number[] | null): void {
    if (this.machine.joint === "hinge") return;
    const centre = found?.centre ?? live ?? this.machine.nominal;
    this.centre.position.fromArray(centre);
    this.isNew = found?.centre != null;
    this.old.visible = live !== null && this.isNew;
    if (live !== null) this.old.position.fromArray(live);
    this.ellipsoid.visible = this.isNew && found?.covariance !== undefined;
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
      ).multiplyScalar(this.distance * this.size).add(new Vector3(0, 0, MIDDLE * this.size));
      this.camera.lookAt(0, 0, MIDDLE * this.size);
      this.renderer.render(this.scene, this.camera);
      this.frames += 1;
    }
    return moving;
  }

  private drawBase(): void {
    const corners: number[][] = [];
    for (const point of this.machine.base) {
      // two cables may leave one point
      if (!corners.some((corner) => Math.hypot(...corner.map((value, k) => value - point[k]!)) < 1)) corners.push(point);
    }
    corners.forEach((corner, index) => {
      const side = rod(4, GREY);
      span(side, corner, corners[(index + 1) % corners.length]!);
      const box = new Mesh(new BoxGeometry(16, 16, 16), new MeshLambertMaterial({ color: GREY }));
      box.position.fromArray(corner);
      this.baseGroup.add(side, box);
      if (corners.length === 3) {
        const text = label(`B${index + 1}`);
        text.position.set(corner[0]! * 1.22, corner[1]! * 1.22, corner[2]!);
        this.baseGroup.add(text);
      }
    });
  }

  private put(placed: Placed): void {
    this.shown = placed;
    const ends = this.machine.platform.map((point) => transform(placed, point));
    this.machine.base.forEach((from, cable) => {
      const { mesh, text } = this.cables[cable]!;
      const to = transform(placed, this.machine.ends[cable]!);
      span(mesh, from, to, this.marked === cable ? MARKED : 1);
      // two cables leave each base point: their names stand at different heights
      const share = cable % 2 === 0 ? 0.36 : 0.5;
      text.position.fromArray(from.map((value, k) => value + share * (to[k]! - value)));
    });
    this.cuff.slice(0, ends.length).forEach((mesh, side) => span(mesh, ends[side]!, ends[(side + 1) % ends.length]!));
    // the arm goes from the joint through the middle of the cuff
    const axis = rotate(placed, this.axis);
    const middle = mean(ends);
    this.arm.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3().fromArray(axis));
    this.arm.position.fromArray(middle.map((value, k) => value - this.cuffAt * axis[k]!));
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
      const axis = rotate(pose, this.axis);
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
