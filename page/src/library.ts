// The library, compiled to WebAssembly: codec and mathematics of the firmware itself.

/** A message of the device: its name in the DBC and its fields; codes are numbers. */
export interface Message {
  name: string;
  [field: string]: number | string | number[] | null;
}

/** Where the platform stands: rotation from {P} to {B} row by row, origin in {B} (mm). */
export interface Placed {
  rotation: number[];
  origin: number[];
  /** Of a hinge: how far it bends, rad. */
  angle?: number;
  /** What each cable leaves, mm; only once a centre is determined. */
  residuals?: number[];
  /** The centre as this pose alone shows it, and as the joint's model has it in this pose, mm. */
  centre?: number[];
  path?: number[];
}

export interface Identification {
  /** The joint's centre moves with the arm. */
  moving?: boolean;
  refusal: string | null;
  centre: number[] | null;
  sigma?: number[];
  radii?: number[];
  /** xx, yx, yy, zx, zy, zz, mm². */
  covariance?: number[];
  noise?: number;
  rejected?: [number, number][];
  sigma_after: (number | null)[];
  poses: (Placed | null)[];
  next: { axis: number[]; torsion: number; sigma: number } | null;
}

/** Where each of the cables leaves the base, in {B}, and ends, in {P}; the end-points in {P}; mm. */
export interface Machine {
  joint: "ball" | "hinge";
  base: number[][];
  ends: number[][];
  platform: number[][];
  /** Where the centre is expected, or where the forearm's point of the axis stands, mm. */
  nominal: number[];
  /** Of a hinge: the direction of its axis in {B}, and the point of it in {P}, mm. */
  axis?: number[];
  pivot?: number[];
  /** The platform with the arm at home. */
  home: Placed | null;
}

/** A parameter as the library's table has it. */
export interface Parameter {
  index: number;
  name: string;
  unit: string;
  single: boolean;
  default: number;
  minimum: number;
  maximum: number;
  guarded: boolean;
  text: string;
}

export interface Words {
  protocol: number;
  /** The identifiers that belong to the board: the first, and how many. */
  base: number;
  block: number;
  reasons: [number, string, string, string][];
  /** Code, text, name. */
  guidance: [number, string, string][];
  states: [number, string][];
  opcodes: [number, string][];
  operations: [number, string][];
}

interface Exports {
  memory: WebAssembly.Memory;
  input(): number;
  input_size(): number;
  output(): number;
  receive(len: number): number;
  decode(len: number): number;
  command(opcode: number, run: number, argument: number, nonce: number): number;
  forget(): number;
  words(): number;
  parameters(): number;
  parameter_request(operation: number, index: number, nonce: number, bits: number): number;
  configure(len: number): number;
  machine(): number;
  place(len: number): number;
  identify(len: number): number;
  hinge(len: number): number;
}

export class Library {
  readonly words: Words;
  readonly parameters: Parameter[];
  /** The machine that the board is; until it has said so, the one of the defaults. */
  machine: Machine;
  private readonly text = new TextDecoder();

  private constructor(private readonly wasm: Exports) {
    this.words = this.json(wasm.words()) as Words;
    this.machine = this.json(wasm.machine()) as Machine;
    type Row = [number, string, string, number, number, number, number, number, string];
    this.parameters = (this.json(wasm.parameters()) as Row[]).map(
      ([index, name, unit, single, standard, minimum, maximum, guarded, text]) =>
        ({ index, name, unit, single: single === 1, default: standard, minimum, maximum, guarded: guarded === 1, text }));
  }

  static async load(bytes: BufferSource | Promise<Response>): Promise<Library> {
    const source = await bytes;
    const { instance } =
      source instanceof Response
        ? await WebAssembly.instantiateStreaming(source)
        : await WebAssembly.instantiate(source);
    return new Library(instance.exports as unknown as Exports);
  }

  /** Bytes of an SLCAN line to the messages in them. */
  receive(bytes: Uint8Array): Message[] {
    const messages: Message[] = [];
    for (let at = 0; at < bytes.length; at += this.wasm.input_size()) {
      const part = this.put(bytes.subarray(at, at + this.wasm.input_size()));
      messages.push(...(this.json(this.wasm.receive(part)) as Message[]));
    }
    return messages;
  }

  /** One frame to the message in it. */
  decode(id: number, data: Uint8Array): Message | null {
    const frame = new Uint8Array(2 + data.length);
    frame.set([id & 0xff, id >> 8]);
    frame.set(data, 2);
    const len = this.wasm.decode(this.put(frame));
    return len === 0 ? null : (this.json(len) as Message);
  }

  /** Another board, or another moment of a recording. */
  forget(): void {
    this.wasm.forget();
  }

  /** A command as a line of SLCAN; empty for the accept of a centre that was not shown whole. */
  command(opcode: string, run: number, argument: number, nonce: number): Uint8Array {
    const code = this.words.opcodes.find(([, name]) => name === opcode)?.[0] ?? 0;
    return this.bytes(this.wasm.command(code, run, argument, nonce)).slice();
  }

  /** A request about parameters as a line of SLCAN; empty for an operation that is not known. */
  parameterRequest(operation: string, index: number, nonce: number, bits: number): Uint8Array {
    const code = this.words.operations.find(([, name]) => name === operation)?.[0] ?? 0;
    return this.bytes(this.wasm.parameter_request(code, index, nonce, bits)).slice();
  }

  /** Takes the machine from the board's parameters (index, bits); the answer names one that contradicts the others. */
  configure(values: Iterable<[number, number]>): string {
    const words = new Uint32Array([...values].flat());
    const complaint = this.text.decode(this.bytes(this.wasm.configure(this.put(new Uint8Array(words.buffer)))));
    this.machine = this.json(this.wasm.machine()) as Machine;
    return complaint;
  }

  place(lengths: number[]): Placed | null {
    return this.json(this.wasm.place(this.put(singles([lengths])))) as Placed | null;
  }

  /** Null for a hinge. */
  identify(poses: number[][]): Identification | null {
    return this.json(this.wasm.identify(this.put(singles(poses)))) as Identification | null;
  }

  /** The forearm turns about this hinge from now on: axis and point in the base, in the forearm, offset; about the drawn one for
   *  an empty list. */
  turnAbout(numbers: number[]): void {
    const machine = this.json(this.wasm.hinge(this.put(singles([numbers])))) as Machine | null;
    if (machine !== null) this.machine = machine;
  }

  reason(code: number): { name: string; text: string; remedy: string } {
    const found = this.words.reasons.find(([known]) => known === code);
    return { name: found?.[1] ?? `code ${code}`, text: found?.[2] ?? "", remedy: found?.[3] ?? "" };
  }

  guidance(code: number): string {
    return this.words.guidance.find(([known]) => known === code)?.[1] ?? "";
  }

  guidanceName(code: number): string {
    return this.words.guidance.find(([known]) => known === code)?.[2] ?? "";
  }

  state(code: number): string {
    return this.words.states.find(([known]) => known === code)?.[1] ?? `state ${code}`;
  }

  private put(bytes: Uint8Array): number {
    const len = Math.min(bytes.length, this.wasm.input_size());
    new Uint8Array(this.wasm.memory.buffer, this.wasm.input(), len).set(bytes.subarray(0, len));
    return len;
  }

  private bytes(len: number): Uint8Array {
    return new Uint8Array(this.wasm.memory.buffer, this.wasm.output(), len);
  }

  private json(len: number): unknown {
    return JSON.parse(this.text.decode(this.bytes(len)));
  }
}

function singles(poses: number[][]): Uint8Array {
  return new Uint8Array(new Float32Array(poses.flat()).buffer);
}
