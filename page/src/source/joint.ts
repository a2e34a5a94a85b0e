// Which joint a recording is of. The board says it when it starts or is asked: late in a recording, or never.

import type { Message } from "../library.ts";
import { BALL, type Joint } from "../model.ts";
import type { Recording } from "./recording.ts";

/** A hinge of a recording without any pose. */
const MOST_CABLES = 4;

/** By what the board says, else by what only a hinge sends and the cables of the poses. */
export function jointOf({ ids, lengths, data }: Recording, decode: (id: number, data: Uint8Array) => Message | null): Joint {
  const names = new Map<number, string>();
  let [isHinge, cables] = [false, 0];
  for (let index = 0; index < ids.length; index += 1) {
    const id = ids[index]!;
    const message = () => decode(id, data.subarray(8 * index, 8 * index + lengths[index]!));
    if (!names.has(id)) names.set(id, message()?.name ?? "");
    const name = names.get(id)!;
    if (name === "Module") {
      const module = message();
      if (module !== null) return { isHinge: Number(module["joint"]) === 1, cables: Number(module["cables_in_use"]) };
    }
    if (name.includes("Hinge")) isHinge = true;
    else if (name === "RawLength") cables = Math.max(cables, Number(message()?.["cable"] ?? 0));
  }
  return isHinge ? { isHinge, cables: cables > 0 ? cables : MOST_CABLES } : BALL;
}
