// Requests to the device: sent again until they are answered, obeyed once.

import type { Library, Message } from "./library.ts";

/** Longest wait for an answer before the request is sent again, and how often: an emulated board on a busy machine stands
 *  still for seconds. */
const ANSWER_MS = 400;
const TRIES = 30;
/** The board obeys so many requests within a second and no more: then a while is waited before the next. */
const TOO_MANY_MS = 200;

export class Device {
  private nonce = Math.floor(Math.random() * 0xffff);
  private readonly waiting = new Map<string, (answer: Message) => void>();

  constructor(
    private readonly library: Library,
    private readonly send: (bytes: Uint8Array) => void,
  ) {}

  /** Hears answers among the messages. */
  take(message: Message): void {
    if (message.name === "Answer") this.waiting.get(`${message["nonce"]}`)?.(message);
    if (message.name === "Parameter") this.waiting.get(keyOf(message["parameter"], message["nonce"]))?.(message);
  }

  /** The answer to a command, or null when none came. */
  async ask(opcode: string, run = 0, argument = 0): Promise<Message | null> {
    const nonce = this.next();
    return this.exchange(`${nonce}`, this.library.command(opcode, run, argument, nonce));
  }

  /** The answer to a request about a parameter, or null when none came. */
  async parameter(operation: string, index = 0, bits = 0): Promise<Message | null> {
    for (;;) {
      const nonce = (this.next() % 0xff) + 1;
      const answer = await this.exchange(keyOf(index, nonce), this.library.parameterRequest(operation, index, nonce, bits));
      if (answer === null || this.library.reason(Number(answer["code"])).name !== "TooManyCommands") return answer;
      await new Promise((resolve) => setTimeout(resolve, TOO_MANY_MS));
    }
  }

  private next(): number {
    this.nonce = (this.nonce % 0xffff) + 1;
    return this.nonce;
  }

  private async exchange(key: string, line: Uint8Array): Promise<Message | null> {
    if (line.length === 0) return null;
    for (let attempt = 0; attempt < TRIES; attempt += 1) {
      const answered = new Promise<Message | null>((resolve) => {
        this.waiting.set(key, resolve);
        setTimeout(() => resolve(null), ANSWER_MS);
      });
      this.send(line);
      const answer = await answered;
      this.waiting.delete(key);
      if (answer !== null) return answer;
    }
    return null;
  }
}

function keyOf(index: unknown, nonce: unknown): string {
  return `parameter ${index} ${nonce}`;
}
