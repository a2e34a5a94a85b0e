// Commands to the device: sent again until they are answered, obeyed once.

import type { Library, Message } from "./library.ts";

const ANSWER_MS = 400;
const TRIES = 5;

export class Device {
  private nonce = Math.floor(Math.random() * 0xffff);
  private readonly waiting = new Map<number, (answer: Message) => void>();

  constructor(
    private readonly library: Library,
    private readonly send: (bytes: Uint8Array) => void,
  ) {}

  /** Hears answers among the messages. */
  take(message: Message): void {
    if (message.name === "Answer") this.waiting.get(Number(message["nonce"]))?.(message);
  }

  /** The answer's code, or null when none came. */
  async ask(opcode: string, run = 0, argument = 0): Promise<number | null> {
    this.nonce = (this.nonce % 0xffff) + 1;
    const nonce = this.nonce;
    const line = this.library.command(opcode, run, argument, nonce);
    if (line.length === 0) return null;
    for (let attempt = 0; attempt < TRIES; attempt += 1) {
      const answered = new Promise<Message | null>((resolve) => {
        this.waiting.set(nonce, resolve);
        setTimeout(() => resolve(null), ANSWER_MS);
      });
      this.send(line);
      const answer = await answered;
      this.waiting.delete(nonce);
      if (answer !== null) return Number(answer["code"]);
    }
    return null;
  }
}
