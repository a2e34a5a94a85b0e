// The board's parameters: all that it has, in one table; values are prepared one by one, and saved together.

import type { Device } from "./device.ts";
import type { Library, Message, Parameter } from "./library.ts";
import { element, sentence, write } from "./panel.ts";
import { words } from "./words.ts";

/** So many requests are on their way at once: a board's serial line holds no more. */
const AT_ONCE = 4;

export class ParameterTable {
  private readonly dialog = element<HTMLDialogElement>("parameters");
  private device: Device | null = null;
  private reading: Promise<boolean> | null = null;
  private readonly inUse = new Map<number, number>();
  private readonly prepared = new Map<number, number>();

  constructor(private readonly library: Library) {
    element("parameters-close").onclick = () => this.dialog.close();
    element("parameters-save").onclick = () => void this.save();
    element("parameters-discard").onclick = () => void this.discard();
    const filter = element<HTMLInputElement>("parameters-filter");
    filter.oninput = () => this.show();
    element("parameters-rows").onchange = (event) => {
      if (event.target instanceof HTMLInputElement) void this.write(event.target);
    };
  }

  /** Shows what the board has now. */
  async open(device: Device): Promise<void> {
    if (!this.dialog.open) this.dialog.showModal();
    this.device = device;
    this.say(words.parameters.reading);
    const whole = await this.read(device);
    // something else may have been said meanwhile
    if (element("parameters-said").textContent === words.parameters.reading) this.say(whole ? "" : words.actions.noAnswer);
  }

  close(): void {
    this.device = this.reading = null;
    this.inUse.clear();
    this.prepared.clear();
    this.dialog.close();
  }

  /** Reads all values; true when each has come. The machine in the library is then the board's. */
  read(device: Device): Promise<boolean> {
    // who asks while another reads waits for the same
    this.reading ??= this.readAll(device).finally(() => {
      this.reading = null;
    });
    return this.reading;
  }

  /** The same of a board that has just become another machine: what was being read before is a mixture of both. */
  async readAnew(device: Device): Promise<boolean> {
    await this.reading;
    return this.read(device);
  }

  private async readAll(device: Device): Promise<boolean> {
    const [left, whole] = [[...this.library.parameters], { come: true }];
    const readOne = async ({ index }: Parameter) => {
      for (const [operation, values] of [["Read", this.inUse], ["ReadPrepared", this.prepared]] as const) {
        const answer = await device.parameter(operation, index);
        if (answer === null) whole.come = false;
        else if (this.nameOf(answer) === "Fine") values.set(index, Number(answer["bits"]));
      }
    };
    const readOn = async () => {
      for (let next = left.shift(); next !== undefined && whole.come; next = left.shift()) await readOne(next);
    };
    await Promise.all(Array.from({ length: AT_ONCE }, readOn));
    if (whole.come) this.library.configure(this.inUse);
    if (this.dialog.open) this.show();
    return whole.come;
  }

  private show(): void {
    const wanted = element<HTMLInputElement>("parameters-filter").value.trim().toLowerCase();
    const rows = this.library.parameters.filter(({ name, text }) => `${name} ${text}`.toLowerCase().includes(wanted));
    write("parameters-rows", rows.map((parameter) => this.row(parameter)).join(""));
    const differs = [...this.prepared].some(([index, bits]) => this.inUse.get(index) !== bits);
    for (const id of ["parameters-save", "parameters-discard"]) element<HTMLButtonElement>(id).disabled = !differs;
  }

  private row(parameter: Parameter): string {
    const { index, name, unit, minimum, maximum, text, guarded } = parameter;
    const [now, next] = [this.inUse.get(index), this.prepared.get(index)];
    const value = (bits: number | undefined) => bits === undefined ? "" : shortest(parameter, bits);
    const label = `${name} ${unit}`.trim();
    const field = `<input data-index="${index}" value="${value(next)}" inputmode="decimal" aria-label="${label}">`;
    return `<tr${now === next ? "" : " class=\"prepared\""}><th scope="row">${name}<small>${text}</small></th>`
      + `<td>${now === undefined ? words.parameters.secret : value(now)}</td><td>${field}</td><td>${unit}</td>`
      + `<td>${digits(parameter, minimum)} … ${digits(parameter, maximum)}</td><td>${digits(parameter, parameter.default)}</td>`
      + `<td>${guarded ? words.parameters.guarded : ""}</td></tr>`;
  }

  private async write(field: HTMLInputElement): Promise<void> {
    const parameter = this.library.parameters.find(({ index }) => index === Number(field.dataset["index"]));
    if (parameter === undefined || this.device === null) return;
    const value = Number(field.value.replace(",", "."));
    const possible = field.value.trim() !== "" && (parameter.single ? Number.isFinite(value) : Number.isInteger(value) && value >= 0);
    if (!possible) this.say(words.parameters.noNumber(parameter.name, field.value));
    else {
      const answer = await this.device.parameter("Write", parameter.index, bitsOf(parameter, value));
      if (this.obeyed(parameter.name, answer)) this.prepared.set(parameter.index, bitsOf(parameter, value));
    }
    this.redraw();
  }

  private async save(): Promise<void> {
    if (this.device === null) return;
    const answer = await this.device.parameter("Save");
    if (this.obeyed(words.parameters.save, answer)) {
      for (const [index, bits] of this.prepared) this.inUse.set(index, bits);
      this.say(words.parameters.saved);
    } else if (answer !== null && this.nameOf(answer) === "ParametersContradict") {
      const culprit = this.library.parameters.find(({ index }) => index === Number(answer["bits"]));
      this.say(words.parameters.contradict(culprit?.name ?? ""));
    }
    this.redraw();
  }

  private async discard(): Promise<void> {
    if (this.device === null || !this.obeyed(words.parameters.discard, await this.device.parameter("Discard"))) return;
    for (const [index, bits] of this.inUse) this.prepared.set(index, bits);
    this.redraw();
  }

  /** What was typed and refused gives way to what holds; the keyboard stays where it is. */
  private redraw(): void {
    const at = document.activeElement instanceof HTMLElement ? document.activeElement.dataset["index"] : undefined;
    write("parameters-rows", "");
    this.show();
    document.querySelector<HTMLElement>(`#parameters-rows [data-index="${at}"]`)?.focus();
  }

  private obeyed(what: string, answer: Message | null): boolean {
    const name = answer === null ? "" : this.nameOf(answer);
    if (name === "Fine") this.say("");
    else if (answer === null) this.say(words.actions.noAnswer);
    else {
      const reason = this.library.reason(Number(answer["code"]));
      this.say(`${words.actions.refused(what)}: ${sentence(reason.text)} ${sentence(reason.remedy)}`);
    }
    return name === "Fine";
  }

  private nameOf(answer: Message): string {
    return this.library.reason(Number(answer["code"])).name;
  }

  private say(text: string): void {
    // it may repeat what was typed: no markup
    element("parameters-said").textContent = text;
  }
}

const view = new DataView(new ArrayBuffer(4));

/** The four bytes of a value. */
export function bitsOf(parameter: Parameter, value: number): number {
  if (parameter.single) view.setFloat32(0, value);
  else view.setUint32(0, value);
  return view.getUint32(0);
}

/** The value in four bytes, with as many digits as tell it from its neighbours. */
export function shortest(parameter: Parameter, bits: number): string {
  view.setUint32(0, bits);
  return digits(parameter, parameter.single ? view.getFloat32(0) : bits);
}

function digits(parameter: Parameter, value: number): string {
  if (!parameter.single) return String(value);
  for (let count = 1; count < 9; count += 1) {
    const short = Number(value.toPrecision(count));
    if (Math.fround(short) === Math.fround(value)) return String(short);
  }
  return String(Number(value.toPrecision(9)));
}
