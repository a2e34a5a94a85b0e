// Which commands there are at which moment.

import type { Model } from "./model.ts";
import { UNCONFIRMED } from "./panel.ts";

export const BUTTONS = ["Start", "StartTwoPhases", "Accept", "Reject", "Abort", "Acknowledge", "Confirm"] as const;
export type Button = (typeof BUTTONS)[number];

/** A set is being collected or computed. */
export function isInSet(state: string): boolean {
  return ["Collecting", "Identifying", "Verifying"].includes(state);
}

/** What can be commanded in a state. A hinge has no shoulder blade. */
export function allowed({ heartbeat, isHinge }: Model, state: string): Record<Button, boolean> {
  const start = state === "Idle" || state === "Failed";
  return {
    Start: start,
    StartTwoPhases: start && !isHinge,
    Accept: state === "Review",
    Reject: state === "Review",
    Abort: isInSet(state),
    Acknowledge: state === "Failed" || Number(heartbeat?.["unacknowledged"] ?? 0) === 1 && state === "Idle",
    Confirm: state === "Idle" && Number(heartbeat?.["standing"] ?? 0) === UNCONFIRMED,
  };
}
