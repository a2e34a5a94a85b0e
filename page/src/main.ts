// The page: messages in, model and mathematics, picture and words out, commands back.

import { allowed, BUTTONS, isInSet, type Button } from "./buttons.ts";
import { accuracyChart, residualChart } from "./charts.ts";
import { Device } from "./device.ts";
import { angleText, hingeTable, inPicture } from "./hinge.ts";
import { Library, type Identification, type Message } from "./library.ts";
import { BALL, Model } from "./model.ts";
import { NumberingCheck } from "./numbering.ts";
import { boardList, centreTable, element, explained, faultList, guidance, stateLine, write, type Situation } from "./panel.ts";
import { ParameterTable } from "./parameters.ts";
import { ArmScene } from "./scene.ts";
import { magnification } from "./shapes.ts";
import { jointOf } from "./source/joint.ts";
import { framesUntil, readRecording, type Recording } from "./source/recording.ts";
import type { Listener, Source } from "./source/source.ts";
import { openSerial, type SerialLike } from "./source/webserial.ts";
import { openWebSocket } from "./source/websocket.ts";
import { words } from "./words.ts";

/** The heartbeat comes every 100 ms; without one for so long the board is called silent. */
const SILENCE_MS = 2000;
/** A pose's lengths come by themselves; a board that does not send them is asked after so long. */
const ASK_FOR_POSE_MS = 300;
/** Argument of `Start`: the shoulder blade is held first. */
const TWO_PHASES = 2;

class Page {
  private model = new Model();
  private device: Device | null = null;
  private source: Source | null = null;
  private recording: Recording | null = null;
  private recorded = BALL;
  private playing: number | null = null;
  private found: Identification | null = null;
  private computed = -1;
  /** The centre in use as it is in the picture. */
  private shown = "";
  private drawn = "";
  private placed: number[] | null = null;
  private heard = performance.now();
  private asked = 0;
  private notice = "";
  private readonly situation: Situation = { connected: false, silent: false, recording: false, complaint: "" };
  private readonly scene: ArmScene | null;
  private readonly numbering: NumberingCheck;
  private readonly parameters: ParameterTable;
  /** The machine that has been read from the board, as it names it. */
  private rig: number | null = null;
  /** Which start of the board was heard last. */
  private boot: number | null = null;

  constructor(private readonly library: Library) {
    let scene: ArmScene | null = null;
    try {
      scene = new ArmScene(element("arm"), library.machine);
    } catch {
      write("scene-note", words.scene.noWebgl);
    }
    this.scene = scene;
    this.numbering = new NumberingCheck(library, () => this.model, (cable) => scene?.mark(cable));
    this.parameters = new ParameterTable(library);
    this.wire();
  }

  /** Turns of the page's loop, for whoever measures. */
  ticks = 0;

  start(): void {
    if (location.protocol.startsWith("http")) this.connect();
    const frame = () => {
      this.ticks += 1;
      this.update();
      this.scene?.frame();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  /** Frames drawn so far, for whoever measures. */
  get frames(): number {
    return this.scene?.frames ?? 0;
  }

  private connect(): void {
    this.leave();
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.arrive(openWebSocket(`${scheme}://${location.host}/bus`, this.listener()));
  }

  private async connectSerial(): Promise<void> {
    const serial = (navigator as unknown as { serial?: SerialLike }).serial;
    this.leave();
    const opened = await openSerial(serial, this.listener());
    if (typeof opened === "string") this.situation.complaint = opened;
    else this.arrive(opened);
  }

  private async openRecording(file: File): Promise<void> {
    this.leave();
    const opened = readRecording(new Uint8Array(await file.arrayBuffer()), this.library.words.base, this.library.words.block);
    if (typeof opened === "string") {
      this.situation.complaint = opened;
      return;
    }
    this.recording = opened;
    this.recorded = jointOf(opened, (id, data) => this.library.decode(id, data));
    this.situation.connected = this.situation.recording = true;
    this.notice = opened.cut ? words.sources.cut : "";
    const slider = element<HTMLInputElement>("slider");
    slider.max = String(opened.times.at(-1) ?? 0);
    slider.value = slider.max;
    this.seek(Number(slider.max));
  }

  private arrive(source: Source): void {
    this.source = source;
    this.device = new Device(this.library, (bytes) => source.send?.(bytes));
  }

  /** Leaves the source; everything that was known of it is forgotten. */
  private leave(): void {
    this.source?.close();
    this.source = this.device = this.recording = this.playing = this.rig = this.boot = null;
    this.numbering.close();
    this.parameters.close();
    this.model = new Model();
    this.library.forget();
    this.placed = null;
    this.found = null;
    this.computed = -1;
    this.notice = "";
    Object.assign(this.situation, { connected: false, silent: false, recording: false, complaint: "" });
  }

  private listener(): Listener {
    return {
      bytes: (bytes) => this.library.receive(bytes).forEach((message) => this.take(message)),
      opened: () => {
        this.situation.connected = true;
        this.heard = performance.now();
        void this.device?.ask("Query");
      },
      gone: (reason) => {
        this.leave();
        this.situation.complaint = `${reason} ${words.sources.goneRemedy}`;
      },
    };
  }

  private take(message: Message): void {
    if (message.name === "Heartbeat") this.heard = performance.now();
    this.device?.take(message);
    this.model.take(message);
    if (message.name === "Identity") this.meet(Number(message["boot"]));
    const versions = this.model.versions;
    if (message.name === "Versions" && versions !== null && Number(versions["protocol"]) !== this.library.words.protocol) {
      const complaint = words.sources.protocol(Number(versions["protocol"]), this.library.words.protocol);
      this.leave();
      this.situation.complaint = complaint;
    } else if (message.name === "Versions" && versions !== null) void this.readMachine(Number(versions["rig"]));
  }

  /** A board that has started anew may be another machine; what it says then goes by before an adapter's channel is open again. */
  private meet(boot: number): void {
    const isAnother = this.boot !== null && this.boot !== boot;
    this.boot = boot;
    if (isAnother) void this.device?.ask("Query");
  }

  /** One image serves every machine: what the board is, it says by its parameters. */
  private async readMachine(rig: number): Promise<void> {
    const device = this.device;
    if (device === null || rig === this.rig) return;
    this.rig = rig;
    // asked again with the next Versions, should answers have been lost
    if (!(await this.parameters.readAnew(device))) {
      this.rig = null;
      void device.ask("Query");
    }
    this.scene?.setMachine(this.library.machine);
    this.placed = null;
    this.shown = "";
    this.computed = -1;
  }

  /** How things stood at a moment of the recording. */
  private seek(seconds: number): void {
    const recording = this.recording;
    if (recording === null) return;
    this.model = new Model(this.recorded);
    this.library.forget();
    for (const index of framesUntil(recording, seconds)) {
      const data = recording.data.subarray(8 * index, 8 * index + recording.lengths[index]!);
      const message = this.library.decode(recording.ids[index]!, data);
      if (message !== null) this.model.take(message);
    }
    this.computed = -1;
    const minutes = Math.floor(seconds / 60);
    write("time", `${minutes}:${(seconds % 60).toFixed(1).padStart(4, "0")}`);
  }

  private update(): void {
    const { model, situation } = this;
    situation.silent = this.source !== null && situation.connected && performance.now() - this.heard > SILENCE_MS;
    this.play();
    this.askForLengths();
    if (model.lengths !== null && model.lengths !== this.placed) {
      this.placed = model.lengths;
      const placed = this.isOfThisMachine() ? this.library.place(model.lengths) : null;
      if (placed !== null) this.scene?.follow(placed, model.now?.centre ?? null);
    }
    if (this.computed !== model.evidence) {
      this.computed = model.evidence;
      this.compute();
      this.shown = "";
    }
    if (model.isHinge) this.showHinge();
    else {
      const live = model.live.every((value) => value !== null) ? model.live.map((value) => value!.value) : null;
      if (this.shown !== String(live)) {
        this.shown = String(live);
        this.scene?.show(this.found, live);
      }
    }
    const state = JSON.stringify([model.revision, situation, this.notice, this.computed]);
    if (state !== this.drawn) {
      this.drawn = state;
      this.draw();
    }
  }

  /** Is the picture of the joint that is spoken of? Another machine's cables say nothing about this one. */
  private isOfThisMachine(): boolean {
    return this.model.isHinge === (this.library.machine.joint === "hinge");
  }

  /** The hinge in the picture, and how far it bends. */
  private showHinge(): void {
    write("angle", angleText(this.model));
    const { numbers, old, note } = inPicture(this.model, this.library.state(Number(this.model.heartbeat?.["state"])));
    const shown = JSON.stringify([numbers, old, this.isOfThisMachine()]);
    if (this.shown === shown) return;
    this.shown = shown;
    if (this.scene !== null) write("scene-note", this.isOfThisMachine() ? note : words.hinge.otherMachine);
    if (!this.isOfThisMachine()) return;
    this.library.turnAbout(numbers?.map(({ value }) => value) ?? []);
    this.scene?.setMachine(this.library.machine);
    this.scene?.showHinge(numbers, old);
    this.placed = null;
  }

  private compute(): void {
    // of a hinge the board's own numbers are shown
    if (this.model.isHinge || this.library.machine.joint === "hinge") {
      this.found = null;
      return;
    }
    const poses = this.model.whole(false).map((pose) => pose.lengths as number[]);
    this.found = poses.length === 0 ? null : this.library.identify(poses);
    const last = [...this.model.whole(false), ...this.model.whole(true)].at(-1);
    const placed = last === undefined ? this.library.machine.home : this.library.place(last.lengths as number[]);
    if (placed !== null && this.model.lengths === null) this.scene?.moveTo(placed);
    const covariance = this.found?.covariance;
    if (this.scene !== null) write("scene-note", covariance === undefined ? "" : words.scene.magnified(magnification(covariance)));
  }

  private draw(): void {
    const { model, library, situation } = this;
    const advice = guidance(model, library, situation);
    const state = model.heartbeat === null ? "" : library.state(Number(model.heartbeat["state"]));
    document.body.dataset["state"] = situation.silent || situation.complaint !== "" ? "Trouble" : state;
    write("guidance", advice.text);
    write("detail", advice.detail);
    write("state", stateLine(model, library));
    write("notice", this.notice);
    const progress = Number(model.heartbeat?.["progress"] ?? 0);
    element<HTMLProgressElement>("progress").value = progress;
    write("percent", model.heartbeat === null ? "" : `${progress} %`);
    write("centre", model.isHinge ? hingeTable(model) : centreTable(model, this.found));
    for (const id of ["accuracy", "residuals"]) element(id).hidden = model.isHinge;
    element("angle").hidden = !model.isHinge;
    element("arm").style.visibility = this.isOfThisMachine() ? "visible" : "hidden";
    write("faults", faultList(model, library));
    write("board", boardList(model));
    write("accuracy", accuracyChart(this.found?.sigma_after ?? []));
    write("residuals", residualChart(this.found));
    this.scene?.setNextVisible(state === "Collecting");
    element("recorded").hidden = !situation.recording;
    const commanded = this.source !== null && model.heartbeat !== null;
    element<HTMLButtonElement>("numbering-open").disabled = !commanded || isInSet(state);
    element<HTMLButtonElement>("parameters-open").disabled = !commanded;
    const can = allowed(model, state);
    for (const name of BUTTONS) {
      const button = element<HTMLButtonElement>(name);
      button.disabled = !can[name] || this.source === null;
      button.hidden = !can[name];
    }
  }

  /** Lengths that did not come by themselves, one pose after the other. */
  private askForLengths(): void {
    const now = performance.now();
    const missing = this.device === null || now - this.asked < ASK_FOR_POSE_MS ? undefined : this.model.missing();
    if (missing !== undefined) {
      this.asked = now;
      void this.device?.ask("ReadPose", this.model.run, missing.index + (missing.heldOut ? 256 : 0));
    }
  }

  private async command(name: Button): Promise<void> {
    const run = name === "Confirm" ? this.model.liveRun : this.model.run;
    if ((name === "Accept" || name === "Confirm") && !(await this.confirmed(name))) return;
    const starts = name === "Start" || name === "StartTwoPhases";
    if (starts && this.model.heartbeat !== null && Number(this.model.heartbeat["unacknowledged"]) === 1) {
      await this.device?.ask("Acknowledge", Number(this.model.heartbeat["run_id"]));
    }
    const device = this.device;
    const answer = await (starts
      ? device?.ask("Start", 0, name === "Start" ? 0 : TWO_PHASES)
      : device?.ask(name, run));
    if (device === null || answer === null || answer === undefined) this.notice = words.actions.noAnswer;
    else {
      const reason = explained(this.model, this.library, answer["code"]);
      if (reason.name === "NumberingUnchecked") this.numbering.open(device);
      const refused = `${words.actions.refused(words.actions[name])}: ${reason.text} ${reason.remedy}`;
      this.notice = reason.name === "Fine" ? "" : refused;
    }
  }

  private confirmed(name: "Accept" | "Confirm"): Promise<boolean> {
    const dialog = element<HTMLDialogElement>("confirm");
    const [title, titleOfLive] = this.model.isHinge
      ? [words.hinge.confirm, words.hinge.confirmLive] : [words.confirm.title, words.confirm.titleOfLive];
    write("confirm-title", name === "Accept" ? title : titleOfLive);
    write("confirm-centre", this.model.isHinge ? hingeTable(this.model) : centreTable(this.model, this.found));
    dialog.showModal();
    return new Promise((resolve) => {
      dialog.onclose = () => resolve(dialog.returnValue === "yes");
    });
  }

  private play(): void {
    if (this.playing === null) return;
    const slider = element<HTMLInputElement>("slider");
    const now = performance.now();
    const seconds = Number(slider.value) + (now - this.playing) / 1000;
    this.playing = seconds >= Number(slider.max) ? null : now;
    slider.value = String(seconds);
    this.seek(Number(slider.value));
    write("play", this.playing === null ? words.time.play : words.time.pause);
  }

  private wire(): void {
    for (const name of BUTTONS) {
      const button = element<HTMLButtonElement>(name);
      button.textContent = words.actions[name];
      button.onclick = () => void this.command(name);
    }
    element("websocket").onclick = () => this.connect();
    element("serial").onclick = () => void this.connectSerial();
    const file = element<HTMLInputElement>("file");
    element("open").onclick = () => file.click();
    file.onchange = () => {
      const chosen = file.files?.[0];
      if (chosen !== undefined) void this.openRecording(chosen);
      file.value = "";
    };
    const slider = element<HTMLInputElement>("slider");
    slider.setAttribute("aria-label", words.time.label);
    slider.oninput = () => this.seek(Number(slider.value));
    element("play").onclick = () => {
      if (Number(slider.value) >= Number(slider.max)) slider.value = "0";
      this.playing = this.playing === null ? performance.now() : null;
      write("play", this.playing === null ? words.time.play : words.time.pause);
    };
    element("numbering-open").onclick = () => this.device && this.numbering.open(this.device);
    element("parameters-open").onclick = () => this.device && void this.parameters.open(this.device);
    const texts: [string, string][] = [
      ["numbering-open", words.numbering.open], ["numbering-title", words.numbering.title],
      ["numbering-again", words.numbering.again], ["numbering-close", words.numbering.close],
      ["parameters-open", words.parameters.open], ["parameters-title", words.parameters.title],
      ["parameters-find", words.parameters.filter], ["parameters-save", words.parameters.save],
      ["parameters-discard", words.parameters.discard], ["parameters-close", words.parameters.close],
      ["parameters-note", words.parameters.note],
      ["parameters-columns", `<tr>${words.parameters.columns.map((name) => `<th scope="col">${name}</th>`).join("")}</tr>`],
      ["title", words.title], ["websocket", words.sources.websocket], ["serial", words.sources.serial],
      ["open", words.sources.recording], ["confirm-text", words.confirm.text],
      ["yes", words.confirm.yes], ["no", words.confirm.no], ["faults-title", words.faults.title],
      ["board-title", words.board.title], ["play", words.time.play],
    ];
    for (const [id, text] of texts) write(id, text);
    element("arm").setAttribute("aria-label", words.scene.label);
    document.title = words.title;
  }
}

const page = new Page(await Library.load(fetch("page.wasm")));
page.start();
Object.assign(window, { glenoid: page });
