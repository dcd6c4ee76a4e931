// The page of a person who plays: takes what the program says (rcss_hat/viewer/protocol.py), shows it, sends back what the person does.

import { Facts, History } from "./panels.js";
import { Attention } from "./attention.js";
import { Link } from "./link.js";
import { Pace } from "./pace.js";
import { Pitch } from "./pitch.js";
import { Replay } from "./replay.js";
import { Scores } from "./scores.js";
import { Texts } from "./texts.js";
import { Theme } from "./theme.js";
import { listen } from "./playkeys.js";
import { listenToFinger } from "./touch.js";
import { sayFarewell } from "./ending.js";
import { tellWhere } from "./situation.js";

const $ = (id) => document.getElementById(id);
const BANNER_MS = 1600, DESCRIBE_MS = 1000;
const ARROWS = { ArrowLeft: "\u2190", ArrowUp: "\u2191", ArrowRight: "\u2192", ArrowDown: "\u2193" };
const touch = matchMedia("(pointer: coarse)");

class Viewer {
  constructor(texts) {
    this.texts = texts;
    this.role = "watcher";
    this.plain = true;
    this.setup = this.frame = this.status = null;
    this.frames = 0;
    this.described = -Infinity;
    this.seat = "taken";
    this.lapsed = null;
    this.over = false;
    this.connected = "off";
    this.queue = Promise.resolve();
    this.pitch = new Pitch($("pitch"));
    this.pitch.numbers = false;
    this.facts = new Facts();
    this.history = new History($("history"), this.pitch);
    this.theme = new Theme($("theme"), () => { this.pitch.readColours(); this.history.draw(); }, (choice) => texts.say(`theme_${choice}`));
    this.scores = new Scores(texts);
    this.replay = new Replay(this);
    this.pace = new Pace((message) => this.send(message));
    listen(this);
    this.wire();
    this.attention = new Attention(() => { this.tellLook(); this.showStandstill(); });
    this.showTexts();
    $("game").hidden = false;
    this.link = new Link((message) => this.hear(message), (state) => this.linked(state));
    const draw = (now) => { this.pitch.draw(now); requestAnimationFrame(draw); };
    requestAnimationFrame(draw);
  }

  // -- connection -----------------------------------------------------------------------------------------------------
  send(message) { this.link.send(message); }

  linked(state) {
    this.connected = state;
    if (state === "on") this.tellLook();
    else this.attention.close($("intro"), $("question"));
    this.showConnection();
    this.showStandstill();
  }

  showConnection() {
    const { texts } = this;
    const state = this.over ? "over" : this.connected === "on" ? "on" : "off";
    const on = this.role === "player" ? "connected" : "watching";
    $("connection").dataset.state = state;
    $("connection").querySelector(".text").textContent = texts.say(state === "over" ? "over" : state === "on" ? on : "connecting");
  }

  // One after the other: texts may have to be loaded first.
  hear(message) {
    if (message.type !== "hello") { this.queue = this.queue.then(() => this.take(message)); return; }
    this.queue = this.queue.then(async () => {
      if (message.language) await this.texts.load(message.language);
      $("language").hidden = Boolean(message.language) || this.texts.available.length < 2;
      this.showTexts();
      this.takeHello(message);
    });
  }

  take(message) {
    const kinds = {
      frame: () => this.takeFrame(message.frame),
      demonstration: () => this.takeStatus(message),
      episode: () => this.takeEpisode(message.episode),
      episodes: () => { this.history.set(message.episodes); this.scores.set(message.episodes); },
      setup: () => this.takeSetup(message),
      seat: () => this.takeSeat(message),
      replay: () => { this.replay.take(message); this.showStandstill(); },
      farewell: () => this.takeFarewell(message),
      notice: () => this.notice(message),
      refused: () => this.banner(this.worded(message)),
    };
    kinds[message.type]?.();
  }

  // A remark in the page's language where it has these words, else as it was sent.
  worded({ code, text, values }) {
    const { texts } = this, name = { watching: "another_plays", taken: "another_plays" }[code] ?? code;
    if (code === "no_such_pass") return texts.say(code, { key: values.key ?? "?", passes: texts.list(values.passes) });
    return name && texts.has(name) ? texts.say(name, values) : text;
  }

  takeHello(message) {
    this.plain = message.plain;
    $("details-button").hidden = message.plain;
    this.takeRole(message.role);
  }

  takeRole(role) {
    this.role = role;
    const plays = role === "player";
    this.pitch.playing = plays;
    $("play").hidden = !plays || this.replay.shown;
    document.querySelector("main").classList.toggle("playing", plays);
    $("seat").hidden = plays || this.over;
    this.showConnection();
    if (this.status) this.takeStatus(this.status);
  }

  takeSeat({ role, state }) {
    this.seat = state;
    if (role !== this.role) this.takeRole(role);
    $("seat-text").textContent = this.texts.say(`seat_${state}`);
    $("take-seat").hidden = state === "taken";
    this.showStandstill();
  }

  tellLook() { this.send({ type: "look", value: this.attention.looking }); }

  // Why nothing moves, over the picture.
  showStandstill() {
    const { status, texts } = this, node = $("standstill");
    let text = "";
    if (this.over) text = "";
    else if (this.connected === "replaced") text = texts.say("replaced");
    else if (this.connected === "gone") text = texts.say("link_needed");
    else if (this.connected === "off" && this.setup) text = texts.say("reconnecting");
    else if (status?.standing && !status.finished && !status.replaying && !document.querySelector("dialog[open]")) {
      const what = texts.say(status.stops ? "stands" : "holds");
      if (this.role !== "player") text = texts.say("nobody", { what });
      else if (!this.attention.looking) text = texts.say("click", { what });
    }
    node.hidden = !text;
    if (node.textContent !== text) node.textContent = text;
  }

  takeFarewell(message) {
    this.over = true;
    this.link.end();
    this.pace.flush();
    if (message.url) { location.replace(message.url); return; }
    this.attention.close($("intro"), $("help"), $("confirm"), $("question"));
    sayFarewell(message, this.role === "player", this.texts);
    this.attention.open($("farewell"));
    $("seat").hidden = true;
    this.showConnection();
    this.showStandstill();
  }

  takeSetup(message) {
    this.setup = message.setup;
    this.pitch.setSetup(this.setup);
    $("title").textContent = this.setup.title;
    this.showStandstill();
  }

  takeFrame(frame) {
    if (!this.setup) return;
    const now = performance.now();
    this.frame = frame;
    this.frames += 1;
    this.pace.picture(now, this.status?.standing ?? true);
    if (this.replay.shown) return;
    this.pitch.push(frame, now, 1);
    if (!$("facts").hidden) this.facts.show(frame, this.setup);
    this.scores.running(frame);
    if (this.pitch.playing) { this.showChoices(); this.showLapse(); }
    if (now - this.described > DESCRIBE_MS) this.describe(now);
  }

  describe(now) {
    this.described = now;
    $("pitch").setAttribute("aria-label", `${this.texts.say("pitch")}. ${tellWhere(this.frame, this.texts)}`);
  }

  takeEpisode(episode) {
    this.history.add(episode);
    const { texts } = this, values = { seconds: texts.number(episode.cycles / 10) };
    this.scores.add(episode);
    this.banner(texts.say(episode.reason, values));
    this.announce(this.scores.said(texts.say(episode.reason, values)));
  }

  announce(text) { $("announcer").textContent = text; }

  banner(text) {
    $("banner").textContent = text;
    $("banner").classList.add("shown");
    clearTimeout(this.bannerTimer);
    this.bannerTimer = setTimeout(() => $("banner").classList.remove("shown"), BANNER_MS);
  }

  notice(message) {
    const counts = ["begins", "goes_on"].includes(message.code);
    $("countdown").textContent = counts && message.text ? this.worded(message) : "";
    const text = counts || !message.text ? "" : this.worded(message);
    $("notice").hidden = !text;
    $("notice").textContent = text;
  }

  // -- demonstrating --------------------------------------------------------------------------------------------------
  canPlay() { return this.role === "player" && this.status && !this.status.finished && !this.over; }
  may(command) { return this.status?.commands.includes(command) ?? false; }

  takeStatus(status) {
    this.status = status;
    this.pitch.playing = this.role === "player" && status.by !== "learner";
    this.showStandstill();
    this.scores.status(status);
    if (this.role !== "player") return;
    this.buildPasses();
    this.showButtons();
    const live = !status.finished && !this.over;
    this.ask($("intro"), live && !status.started && this.connected === "on");
    this.ask($("question"), live && status.asking && this.connected === "on");
  }

  ask(dialog, asking) {
    if (asking) this.attention.open(dialog);
    else this.attention.close(dialog);
  }

  showButtons() {
    const { status, texts } = this;
    const show = (id, command, text, pressed, able = true) => {
      const button = $(id);
      button.hidden = !this.may(command);
      button.disabled = status.finished || !able;
      button.setAttribute("aria-pressed", String(pressed));
      if (button.firstElementChild.textContent !== texts.say(text)) button.firstElementChild.textContent = texts.say(text);
    };
    show("pause-recording", "pause", status.paused ? "go_on" : "pause", status.paused);
    show("drop", "drop", status.dropping ? "keep" : "drop", status.dropping);
    show("drop-last", "drop_last", status.last_dropped ? "keep_last" : "drop_last", status.last_dropped, status.last !== null);
    $("finish").hidden = !this.may("stop");
    $("finish").disabled = status.finished;
    $("recording").hidden = !["pause", "drop", "drop_last", "stop"].some((command) => this.may(command));
    $("turns").hidden = !status.turns;
    if (status.turns) {
      const learner = status.by === "learner";
      $("turns-text").textContent = texts.say(learner ? "computer_plays" : "you_play");
      $("turn").firstElementChild.textContent = texts.say(learner ? "take" : "give");
      $("turn").disabled = status.finished;
    }
    for (const row of document.querySelectorAll("#help-keys [data-command]")) {
      row.hidden = !this.may(row.dataset.command) || (row.dataset.command === "take" && !status.turns);
    }
  }

  get passes() { return this.status.actions.map(({ action }) => action).filter((action) => action); }

  buildPasses() {
    const { actions } = this.status, { texts } = this;
    const state = `${texts.language} ${actions.length}`;
    if ($("passes").dataset.state === state) return;
    $("passes").dataset.state = state;
    $("passes").replaceChildren(...actions.map(({ action }) => {
      const button = document.createElement("button"), cap = document.createElement("b"), label = document.createElement("span"), key = document.createElement("kbd");
      button.type = "button";
      button.dataset.action = action;
      button.setAttribute("aria-keyshortcuts", String(action));
      button.setAttribute("aria-label", action ? texts.say("pass", { number: action }) : texts.say("hold_title"));
      cap.textContent = String(action);
      key.textContent = action ? "" : texts.say("space");
      label.textContent = action ? "" : texts.say("hold");
      button.append(cap, label, key);
      key.hidden = Boolean(action);
      listenToFinger(button, () => this.press(action));
      return button;
    }));
    const keys = this.passes;
    $("intro-keys").textContent = texts.say(touch.matches ? "keys_touch" : "keys_keyboard", { passes: texts.list(keys) });
    $("intro-turns").hidden = !this.status.turns;
    $("intro-turns").textContent = texts.say(touch.matches ? "keys_turns_touch" : "keys_turns");
    $("help-passes").replaceChildren(...keys.map((action) => Object.assign(document.createElement("kbd"), { textContent: action })));
  }

  showChoices() {
    const { frame } = this;
    for (const button of $("passes").children) {
      const action = Number(button.dataset.action);
      if (!action) continue;
      const choice = frame.choices.find((c) => c.action === action);
      const arrow = ARROWS[choice?.arrow] ?? "";
      if (button.children[1].textContent !== arrow) button.children[1].textContent = arrow;
      button.classList.toggle("pending", frame.pending === action);
      button.classList.toggle("lapsed", frame.lapsed === action);
      button.classList.toggle("done", frame.action === action);
    }
  }

  showLapse() {
    const { lapsed } = this.frame;
    if (lapsed !== null && this.lapsed === null) this.banner(this.texts.say("lapsed", { number: lapsed }));
    this.lapsed = lapsed;
  }

  press(action) {
    if (!this.canPlay()) return;
    const actions = this.status.actions.map((known) => known.action);
    if (!actions.includes(action)) {
      this.banner(this.texts.say("no_such_pass", { key: action, passes: this.texts.list(this.passes) }));
      return;
    }
    this.send({ type: "press", value: action, at: performance.now() });
    const choice = this.frame?.choices.find((c) => c.action === action);
    if (choice) this.pitch.light(choice.mate, performance.now());
  }

  passTo(mate) {
    if (!this.canPlay()) return;
    this.send({ type: "mate", value: mate, at: performance.now() });
    this.pitch.light(mate, performance.now());
  }

  passTowards(arrow) {
    const choice = this.frame?.choices.find((c) => c.arrow === arrow);
    if (choice) this.passTo(choice.mate);
  }

  record(command) { if (this.may(command)) this.send({ type: "demonstration", value: command }); }
  togglePause() { this.record(this.status.paused ? "resume" : "pause"); }
  toggleTurn() { if (this.status.turns) this.record(this.status.by === "learner" ? "take" : "give"); }
  say() { if (this.frame) this.announce(tellWhere(this.frame, this.texts)); }

  askToFinish() {
    if (!this.may("stop")) return;
    const { kept, recording } = this.status;
    $("confirm-text").textContent = this.texts.say(recording ? "confirm_kept" : "confirm_practice", { n: kept });
    $("confirm").returnValue = "";
    this.attention.open($("confirm"));
  }

  help() { this.attention.open($("help")); }

  // -- wiring ---------------------------------------------------------------------------------------------------------
  showTexts() {
    const { texts } = this;
    texts.fill();
    $("language").replaceChildren(...texts.available.map((name) => new Option(name.toUpperCase(), name, false, name === texts.language)));
    this.pitch.words = { late: texts.say("too_late") };
    this.pitch.arrows = !touch.matches;
    this.theme.apply();
    this.replay.showTexts();
    if (this.status) { this.scores.status(this.status); this.takeStatus(this.status); }
    this.scores.show();
    this.showConnection();
    if (this.role !== "player") $("seat-text").textContent = texts.say(`seat_${this.seat}`);
  }

  wire() {
    if (location.search) history.replaceState(null, "", location.pathname);
    // A button that was clicked gives the keyboard back to the game; one reached by Tab keeps Space and Enter.
    document.addEventListener("click", (event) => { if (event.detail > 0) event.target.closest?.("button")?.blur(); }, true);
    $("intro").addEventListener("close", () => { if (this.canPlay() && !this.status.started && this.connected === "on") this.record("start"); });
    $("question").addEventListener("close", () => { if (this.status.asking && !this.over && this.connected === "on") this.record("here"); });
    $("confirm").addEventListener("close", () => { if ($("confirm").returnValue === "finish") this.record("stop"); });
    $("take-seat").addEventListener("click", () => this.send({ type: "seat" }));
    $("pitch").addEventListener("pointerdown", (event) => {
      if (!this.canPlay() || event.button !== 0 || this.replay.shown) return;
      const mate = this.pitch.mateAt(event.clientX, event.clientY);
      if (mate) this.passTo(mate);
    });
    $("pause-recording").addEventListener("click", () => this.togglePause());
    $("drop").addEventListener("click", () => this.record("drop"));
    $("drop-last").addEventListener("click", () => this.record("drop_last"));
    $("finish").addEventListener("click", () => this.askToFinish());
    $("turn").addEventListener("click", () => this.toggleTurn());
    $("help-button").addEventListener("click", () => this.help());
    $("details-button").addEventListener("click", () => {
      $("facts").hidden = !$("facts").hidden;
      $("details-button").setAttribute("aria-expanded", String(!$("facts").hidden));
      this.history.draw();
    });
    $("language").addEventListener("change", async () => {
      await this.texts.change($("language").value);
      $("language").blur();
      this.showTexts();
    });
  }
}

const texts = new Texts();
await texts.load(null);
globalThis.viewer = new Viewer(texts);
