// What the page knows: a pure function of the messages heard.

import type { Message } from "./library.ts";

export interface Pose {
  index: number;
  heldOut: boolean;
  lengths: (number | null)[];
  sigma: number | null;
}

export interface Value {
  value: number;
  sigma: number;
}

export interface Fault {
  code: number;
  cable: number;
  active: boolean;
}

/** What is known of a joint before the board has said it. */
export interface Joint {
  /** An elbow. */
  isHinge: boolean;
  cables: number;
}
export const BALL: Joint = { isHinge: false, cables: 6 };

/** Axis and foot point in the base, in the forearm, then the offset along the axis: numbers of a hinge. */
export const HINGE_NUMBERS = 13;

/** Where a component stands among them. */
function hingePlace(index: number, isAxis: boolean): number {
  const body = Math.floor(index / 3);
  return 6 * body + (index % 3) + (isAxis || body === 2 ? 0 : 3);
}

export class Model {
  isHinge: boolean;
  cables: number;
  candidateHinge: (Value | null)[] = Array(HINGE_NUMBERS).fill(null);
  liveHinge: (Value | null)[] = Array(HINGE_NUMBERS).fill(null);
  /** How far the hinge in use bends, rad, and what the lengths leave there, mm. */
  angle: Value | null = null;
  heartbeat: Message | null = null;
  versions: Message | null = null;
  outcome: Message | null = null;
  quality: Message | null = null;
  verification: Message | null = null;
  /** What became of the last pose. */
  lastPose: Message | null = null;
  run = 0;
  readonly poses = new Map<string, Pose>();
  candidate: (Value | null)[] = [null, null, null];
  live: (Value | null)[] = [null, null, null];
  liveRun = 0;
  /** L1 to L6 now, mm, where the board sends them. */
  lengths: number[] | null = null;
  slack = 0;
  /** The centre in use where the arm is now, mm, with its σ in its worst direction, where the board sends it. */
  now: { centre: number[]; sigma: number } | null = null;
  readonly faults = new Map<string, Fault>();
  readonly leftOut: Message[] = [];
  /** Grows when a pose gets its last length: time to compute anew. */
  evidence = 0;
  /** Grows with every change. */
  revision = 0;

  constructor({ isHinge, cables }: Joint = BALL) {
    [this.isHinge, this.cables] = [isHinge, cables];
  }

  /** Takes a message. */
  take(message: Message): void {
    // Telemetry moves the arm, not the words.
    if (message.name !== "Telemetry" && message.name !== "HingeAngle") this.revision += 1;
    const run = Number(message["run_id"] ?? 0);
    switch (message.name) {
      case "Heartbeat":
        // A run that is under way is the one to show; an idle device keeps the last one.
        if (Number(message["state"]) !== 0 && run !== this.run) this.begin(run);
        this.heartbeat = message;
        break;
      case "Versions":
        this.versions = message;
        break;
      case "Module":
        this.becomeJoint(Number(message["joint"]) === 1);
        this.cables = Number(message["cables_in_use"]);
        for (const pose of this.poses.values()) pose.lengths.length = Math.min(pose.lengths.length, this.cables);
        break;
      case "CandidateHingeAxis":
      case "CandidateHingePlace":
        this.ofRun(run);
        this.component(this.candidateHinge, message);
        break;
      case "LiveHingeAxis":
      case "LiveHingePlace":
        this.component(this.liveHinge, message);
        this.liveRun = run;
        break;
      case "HingeAngle":
        this.angle = { value: Number(message["angle"]), sigma: Number(message["angle_residual"]) };
        break;
      case "Fault":
        this.faults.set(`${message["code"]}:${message["cable"]}`, {
          code: Number(message["code"]),
          cable: Number(message["cable"]),
          active: Number(message["active"]) === 1,
        });
        break;
      case "Telemetry":
        this.lengths = message["lengths"] as number[];
        this.slack = Number(message["slack"]);
        this.now = message["centre"] === null ? null
          : { centre: message["centre"] as number[], sigma: Number(message["sigma"]) };
        break;
      case "Pose":
        this.pose(message, run);
        break;
      case "RawLength":
        this.length(message, run);
        break;
      case "Outcome":
        this.ofRun(run);
        this.outcome = message;
        break;
      case "Quality":
        this.ofRun(run);
        this.quality = message;
        break;
      case "Verification":
        this.ofRun(run);
        this.verification = message;
        break;
      case "CandidateCentre":
        this.ofRun(run);
        this.candidate[Number(message["axis"])] = value(message);
        break;
      case "LiveCentre":
        this.live[Number(message["axis"])] = value(message);
        this.liveRun = run;
        break;
      case "LeftOut":
        this.ofRun(run);
        if (!this.leftOut.some((known) => known["pose"] === message["pose"])) this.leftOut.push(message);
        break;
    }
  }

  /** Poses of one set with all six lengths, in order. */
  whole(heldOut: boolean): Pose[] {
    return [...this.poses.values()]
      .filter((pose) => pose.heldOut === heldOut && pose.lengths.every((length) => length !== null))
      .sort((a, b) => a.index - b.index);
  }

  /** A pose that was taken but whose lengths have not been heard. */
  missing(): Pose | undefined {
    return [...this.poses.values()].find((pose) => pose.lengths.some((length) => length === null));
  }

  /** What was known of another joint is nothing about this one. */
  private becomeJoint(isHinge: boolean): void {
    if (isHinge === this.isHinge) return;
    this.isHinge = isHinge;
    this.live = [null, null, null];
    this.liveHinge.fill(null);
    this.angle = this.now = null;
    this.begin(this.run);
  }

  private component(numbers: (Value | null)[], message: Message): void {
    const isAxis = message.name.endsWith("Axis");
    numbers[hingePlace(Number(message["hinge_index"]), isAxis)] = isAxis
      ? { value: Number(message["direction"]), sigma: Number(message["direction_sigma"]) }
      : { value: Number(message["place"]), sigma: Number(message["place_sigma"]) };
  }

  private ofRun(run: number): void {
    if (run !== this.run) this.begin(run);
  }

  private begin(run: number): void {
    this.run = run;
    this.poses.clear();
    this.candidate = [null, null, null];
    this.candidateHinge.fill(null);
    this.outcome = this.quality = this.verification = this.lastPose = null;
    this.leftOut.length = 0;
    this.faults.clear();
    this.evidence += 1;
  }

  private pose(message: Message, run: number): void {
    this.ofRun(run);
    this.lastPose = message;
    if (Number(message["reason"]) !== 0) return;
    const pose = this.poseAt(Number(message["index"]), Number(message["held_out"]) === 1);
    pose.sigma = Number(message["predicted_sigma_known"]) === 1 ? Number(message["predicted_sigma"]) : null;
  }

  private length(message: Message, run: number): void {
    this.ofRun(run);
    const [index, heldOut] = [Number(message["index"]), Number(message["held_out"]) === 1];
    const [cable, length] = [Number(message["cable"]) - 1, Number(message["length"])];
    const known = this.poseAt(index, heldOut).lengths[cable] ?? null;
    // the poses with the shoulder blade held make room for those without: the same numbers again
    if (!heldOut && known !== null && known !== length) this.poses.clear();
    const pose = this.poseAt(index, heldOut);
    pose.lengths[cable] = length;
    if (pose.lengths.every((length) => length !== null)) this.evidence += 1;
  }

  private poseAt(index: number, heldOut: boolean): Pose {
    const key = `${heldOut ? 1 : 0}:${index}`;
    let pose = this.poses.get(key);
    if (pose === undefined) {
      pose = { index, heldOut, lengths: Array(this.cables).fill(null), sigma: null };
      this.poses.set(key, pose);
    }
    return pose;
  }
}

function value(message: Message): Value {
  return { value: Number(message["value"]), sigma: Number(message["sigma"]) };
}
