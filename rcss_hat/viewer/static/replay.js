// A game that is looked at again: the person chooses moments, and says what would have been right there.

import { tellWhere } from "./situation.js";

const $ = (id) => document.getElementById(id);

export class Replay {
  constructor(viewer) {
    this.viewer = viewer;
    this.shown = false;
    this.frames = [];
    this.decisions = new Map();
    this.position = 0;
    this.playing = false;
    $("moment").addEventListener("input", () => { this.stop(); this.go(Number($("moment").value)); });
    $("moment-before").addEventListener("click", () => this.jump(-1));
    $("moment-after").addEventListener("click", () => this.jump(1));
    $("moment-play").addEventListener("click", () => this.toggle());
    $("replay-done").addEventListener("click", () => this.done());
    setInterval(() => this.tick(), 100);
  }

  take({ frames, decisions, actions }) {
    const begins = frames && !this.shown;
    this.shown = Boolean(frames);
    $("replay").hidden = !this.shown;
    document.querySelector("main").classList.toggle("replaying", this.shown);
    $("play").hidden = this.shown || this.viewer.role !== "player";
    this.viewer.pitch.replaying = this.shown;
    if (!frames) {
      this.stop();
      this.viewer.pitch.forget();
      if (this.viewer.frame) this.viewer.pitch.push(this.viewer.frame, performance.now(), 1);
      return;
    }
    this.frames = frames;
    this.actions = actions;
    this.decisions = new Map(decisions.map((d) => [d.cycle, d]));
    $("moment").max = frames.length - 1;
    this.build();
    if (begins) this.go(this.last(frames.length - 1));
    else this.show();
    $("replay-done").hidden = this.viewer.role !== "player";
  }

  // The newest decision up to a position, or the position.
  last(position) {
    for (let k = position; k >= 0; k -= 1) if (this.decisions.has(this.frames[k].time)) return k;
    return position;
  }

  get decision() { return this.decisions.get(this.frames[this.position]?.time) ?? null; }

  showTexts() { if (this.shown) { this.build(); this.show(); } else this.showPlaying(); }

  name(action) {
    const { texts } = this.viewer;
    return action ? texts.say("pass", { number: action }) : texts.say("hold");
  }

  build() {
    $("rights").replaceChildren(...this.actions.map((action) => {
      const button = document.createElement("button");
      button.type = "button";
      button.dataset.action = action;
      button.textContent = this.name(action);
      button.addEventListener("click", () => this.correct(action));
      return button;
    }));
    this.showPlaying();
  }

  showPlaying() { $("moment-play").textContent = this.viewer.texts.say(this.playing ? "replay_stop" : "replay_play"); }

  go(position) {
    this.position = Math.min(Math.max(position, 0), this.frames.length - 1);
    this.show();
  }

  jump(step) {
    this.stop();
    let k = this.position + step;
    while (k > 0 && k < this.frames.length - 1 && !this.decisions.has(this.frames[k].time)) k += step;
    this.go(k);
  }

  toggle() {
    this.playing = !this.playing;
    if (this.playing && this.position >= this.frames.length - 1) this.go(0);
    this.showPlaying();
  }

  stop() { this.playing = false; this.showPlaying(); }

  tick() {
    if (!this.shown || !this.playing) return;
    this.go(this.position + 1);
    if (this.position >= this.frames.length - 1) this.stop();
  }

  show() {
    const { viewer, decision } = this, { texts, pitch } = viewer;
    const frame = this.frames[this.position];
    pitch.push({ ...frame, pending: decision?.right ?? null, lapsed: null }, performance.now(), 1);
    $("pitch").setAttribute("aria-label", tellWhere(frame, texts));
    $("moment").value = this.position;
    const seconds = texts.number((frame.time - frame.start) / 10);
    $("moment").setAttribute("aria-valuetext", texts.say("in_seconds", { seconds }));
    const what = decision ? texts.say(`replay_by_${decision.by ?? "person"}`, { action: this.name(decision.action) }) : texts.say("replay_loose");
    const marked = [...this.decisions.values()].filter((d) => d.right !== null).length;
    const parts = [texts.say("replay_was", { seconds, what })];
    if (decision && decision.right !== null) parts.push(texts.say("replay_right", { action: this.name(decision.right) }));
    if (marked) parts.push(texts.say("replay_marks", { n: marked }) + ".");
    $("moment-text").textContent = parts.join(" ");
    for (const button of $("rights").children) {
      button.disabled = !decision || viewer.role !== "player";
      button.setAttribute("aria-pressed", String(decision?.right === Number(button.dataset.action)));
    }
  }

  // Say what would have been right; the same again takes it back.
  correct(action) {
    const { decision } = this;
    if (!decision || !this.actions.includes(action)) return;
    this.stop();
    decision.right = decision.right === action ? null : action;
    this.viewer.send({ type: "correct", cycle: decision.cycle, action: decision.right });
    this.show();
  }

  done() { this.stop(); this.viewer.record("seen"); }

  key(event) {
    const key = event.key.toLowerCase();
    const commands = { arrowleft: () => this.jump(-1), arrowright: () => this.jump(1), home: () => this.go(0), end: () => this.go(this.frames.length - 1), p: () => this.toggle(), " ": () => this.correct(0), enter: () => this.done() };
    if (/^[0-9]$/.test(key)) this.correct(Number(key));
    else if (key in commands) { if (!(event.repeat && ["enter", "p", " "].includes(key))) commands[key](); }
    else return ["arrowup", "arrowdown", "d", "l", "f"].includes(key);
    return true;
  }
}
