// The check of the cables' numbering: pull one after the other, the board looks which encoder moves. A symmetric machine fits
// its lengths under a shifted or a mirrored numbering as well, with a centre that is somewhere else.

import type { Device } from "./device.ts";
import type { Library } from "./library.ts";
import { element, sentence, write } from "./panel.ts";
import { words } from "./words.ts";

/** Time between two looks. */
const LOOK_MS = 300;
/** What passes by itself: somebody moves the arm, or the encoders come. */
const WAITING = ["CableNotPulled", "ArmMoving", "CableLoose", "EncoderSilent", "EncoderFrozen", "EncoderJumped"];

/** What is seen of a cable. */
type Seen = "later" | "now" | "found" | "wrong";

export class NumberingCheck {
  private readonly dialog = element<HTMLDialogElement>("numbering");
  /** Grows with every beginning: one that is not the last has been left. */
  private turn = 0;

  constructor(
    private readonly library: Library,
    /** Is the joint a hinge, and how many cables has it? */
    private readonly joint: () => { isHinge: boolean; cables: number },
    /** Shows one cable among the others, from 0; none for null. */
    private readonly mark: (cable: number | null) => void,
  ) {
    this.dialog.onclose = () => this.leave();
    element("numbering-close").onclick = () => this.dialog.close();
    this.dialog.onkeydown = (event) => {
      if (event.key === "Escape") this.dialog.close();
    };
  }

  /** Begins, or begins again. What the board has seen of a cable since it was switched on is not asked for again. */
  open(device: Device): void {
    // not modal: the picture beside it shows which cable
    if (!this.dialog.open) this.dialog.show();
    element("numbering-again").onclick = () => void this.run(device);
    void this.run(device);
  }

  /** Leaves it. */
  close(): void {
    this.dialog.close();
  }

  private leave(): void {
    this.turn += 1;
    this.mark(null);
  }

  private async run(device: Device): Promise<void> {
    this.turn += 1;
    const turn = this.turn;
    const cables = this.joint().cables;
    element("numbering-again").hidden = true;
    for (let cable = 0; cable < cables; cable += 1) {
      const seen = Array.from({ length: cables }, (_, k): Seen => k < cable ? "found" : k === cable ? "now" : "later");
      // Pulled before the board has noted where the cables are, it would not be seen.
      this.mark(null);
      this.show(words.numbering.wait, "", seen);
      for (;;) {
        const answer = await device.ask("CheckCable", 0, cable + 1);
        if (turn !== this.turn) return;
        if (answer === null) return this.stop(words.actions.noAnswer, "", seen);
        const reason = this.library.reason(Number(answer["code"]));
        if (reason.name === "Fine") break;
        if (reason.name === "WrongCable") {
          seen[cable] = "wrong";
          const moved = Number(answer["detail"]);
          return this.stop(words.numbering.wrong(cable + 1, moved), words.numbering.wrongRemedy, seen);
        }
        const [text, remedy] = [sentence(reason.text), sentence(reason.remedy)];
        if (!WAITING.includes(reason.name)) return this.stop(text, remedy, seen);
        const looks = reason.name === "CableNotPulled";
        this.mark(looks ? cable : null);
        if (looks) this.show(words.numbering.pull(cable + 1, this.runOf(cable)), words.numbering.how, seen);
        else this.show(words.numbering.wait, `${text} ${remedy}`, seen);
        await new Promise((resolve) => setTimeout(resolve, LOOK_MS));
      }
    }
    this.stop(words.numbering.done, "", Array<Seen>(cables).fill("found"));
  }

  /** Where a cable runs, from 0. */
  private runOf(cable: number): string {
    return this.joint().isHinge ? words.hinge.run(cable + 1) : words.numbering.runs[cable] ?? "";
  }

  private stop(text: string, detail: string, seen: Seen[]): void {
    this.mark(null);
    this.show(text, detail, seen);
    element("numbering-again").hidden = seen.every((one) => one === "found");
  }

  private show(text: string, detail: string, seen: Seen[]): void {
    write("numbering-text", text);
    write("numbering-detail", detail);
    write("numbering-seen", seen.map((one, cable) =>
      `<li data-seen="${one}"><strong>L${cable + 1}</strong> ${this.runOf(cable)} `
      + `<span>${words.numbering.seen[one]}</span></li>`).join(""));
  }
}
