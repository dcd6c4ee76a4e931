// The page: takes messages from the viewer's server, shows them, and sends back what the person does.

import { Facts, History, ending, playerName, seconds } from "./panels.js";
import { Pitch, keyText } from "./pitch.js";
import { Attention } from "./attention.js";
import { sayFarewell } from "./ending.js";
import { listen, nextSpeed } from "./keys.js";
import { Theme } from "./theme.js";

const $ = (id) => document.getElementById(id);
const BANNER_MS = 1600;
const RETRY_MS = 1000;
const DESCRIBE_MS = 1000;

class Viewer {
  constructor() {
    this.role = "watcher";
    this.demonstrates = false;
    this.live = true;
    this.setup = null;
    this.frame = null;
    this.frames = 0;
    this.status = null;
    this.play = { playing: false, speed: 1, position: 0, length: 0, complete: false };
    this.described = -Infinity;
    this.seat = "taken";
    this.lapsed = null;
    this.over = false;
    this.pitch = new Pitch($("pitch"));
    this.facts = new Facts();
    this.history = new History($("history"), this.pitch);
    this.theme = new Theme($("theme"), () => { this.pitch.readColours(); this.history.draw(); });
    listen(this);
    this.wire();
    this.attention = new Attention(() => { this.tellLook(); this.showStandstill(); });
    this.connect();
    const draw = (now) => { this.pitch.draw(now); requestAnimationFrame(draw); };
    requestAnimationFrame(draw);
  }

  // -- connection -----------------------------------------------------------------------------------------------------
  connect() {
    this.socket = new WebSocket(new URL("socket", location.href.split("?")[0]).href.replace(/^http/, "ws"));
    this.socket.addEventListener("open", () => { this.connection("on", "connected"); this.tellLook(); });
    this.socket.addEventListener("message", (event) => this.take(JSON.parse(event.data)));
    this.socket.addEventListener("close", (event) => {
      const closed = event.code === 1001; // by the viewer, which is gone for good
      if (!this.over) this.connection("off", closed ? "closed" : "not connected");
      if (!closed && !this.over) setTimeout(() => this.connect(), RETRY_MS);
    });
  }

  connection(state, text) {
    $("connection").dataset.state = state;
    $("connection").querySelector(".text").textContent = text;
  }

  send(message) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  take(message) {
    if (message.type === "frame") this.takeFrame(message.frame);
    else if (message.type === "playback") this.takePlayback(message);
    else if (message.type === "demonstration") this.takeDemonstration(message);
    else if (message.type === "episode") this.takeEpisode(message.episode);
    else if (message.type === "episodes") this.history.set(message.episodes);
    else if (message.type === "setup") this.takeSetup(message);
    else if (message.type === "hello") this.takeHello(message);
    else if (message.type === "seat") this.takeSeat(message);
    else if (message.type === "farewell") this.takeFarewell(message);
    else if (message.type === "notice") this.notice(message.text);
    else if (message.type === "refused") this.banner(message.text);
  }

  takeHello(message) {
    this.demonstrates = message.demonstrate;
    this.takeRole(message.role);
  }

  takeRole(role) {
    this.role = role;
    const play = this.demonstrates && role === "player";
    this.pitch.playing = play;
    $("play").hidden = !play;
    $("help-demonstrate").hidden = !play;
    document.querySelector("main").classList.toggle("playing", play);
    if (!this.over) this.connection("on", role === "player" ? (play ? "you play" : "connected") : "watching");
    if (this.status) this.takeDemonstration(this.status);
    this.arrange();
  }

  // Who plays, and how to play instead.
  takeSeat({ role, state }) {
    this.seat = state;
    if (role !== this.role) this.takeRole(role);
    const [does, act] = this.demonstrates ? ["plays", "Play"] : ["steers", "Steer"];
    $("seat-text").textContent = {
      taken: `Another browser ${does}: the one that opened the link before. When its page is closed or left, a button appears here.`,
      left: `The browser that ${does} is open, but nobody looks at it.`,
      free: `Nobody ${does}: the page of the browser that did is closed.`,
    }[state];
    $("take-seat").textContent = `${act} here`;
    $("take-seat").hidden = state === "taken";
    this.arrange();
    this.showStandstill();
  }

  tellLook() { this.send({ type: "look", value: this.attention.looking }); }

  showStandstill() {
    const { status } = this, looking = this.attention.looking;
    const stands = status?.standing && !status.finished && !this.over && !document.querySelector("dialog[open]");
    $("standstill").hidden = !stands || (this.role === "player" && looking);
    const what = status?.stops ? "The game stands still" : "The keepers hold, and nothing is recorded";
    $("standstill").textContent = this.role === "player" ? `${what}. Click here to go on.` : `${what}: nobody plays.`;
  }

  takeFarewell(message) {
    this.over = true;
    this.connection("over", "finished");
    for (const id of ["help", "confirm", "question"]) $(id).close();
    sayFarewell(message, this.role === "player");
    this.attention.open($("farewell"));
    this.arrange();
  }

  takeSetup(message) {
    this.setup = message.setup;
    this.live = message.live;
    this.pitch.setSetup(this.setup);
    $("title").textContent = this.setup.title;
    document.title = `${this.setup.title} \u2013 rcss-hat`;
    this.nameTeams(null);
    this.arrange();
  }

  nameTeams(score) {
    ["left", "right"].forEach((side, k) => {
      const node = $(`legend-${side}`), text = this.setup.teams[k] + (score ? ` ${score[k]}` : "");
      if (node.textContent !== text) node.textContent = text;
    });
  }

  arrange() {
    const seek = this.canSeek();
    $("transport").hidden = !seek;
    const watching = this.role !== "player" && !this.over;
    $("seat").hidden = !watching;
    document.querySelector("main").classList.toggle("watching", watching);
    $("help-playback").hidden = !seek;
    document.body.classList.toggle("seekable", seek);
  }

  takeFrame(frame) {
    this.frame = frame;
    this.frames += 1;
    if (!this.setup) return;
    this.nameTeams(frame.score);
    const now = performance.now();
    this.pitch.push(frame, now, this.live ? 1 : this.play.speed);
    this.facts.show(frame, this.setup);
    if (!this.live) this.history.mark(frame.episode);
    if (this.pitch.playing) { this.showChoices(); this.showLapse(); }
    if (now - this.described > DESCRIBE_MS || (!this.live && !this.play.playing)) this.describe(now);
  }

  describe(now) {
    this.described = now;
    const { frame, setup } = this;
    const holder = frame.holder ? `${playerName(frame.holder, setup)} has the ball` : "the ball is loose";
    const time = seconds(frame.time - frame.start);
    const keys = this.pitch.playing ? frame.choices.map((c) => `; key ${c.action} passes to ${playerName(c.mate, setup)}`).join("") : "";
    $("pitch").setAttribute("aria-label", `Episode ${frame.episode}, ${time} seconds; ${holder}${keys}`);
  }

  takeEpisode(episode) {
    this.history.add(episode);
    const text = ending(episode);
    this.banner(text);
    $("announcer").textContent = `Episode ${episode.number}: ${text}.`;
  }

  banner(text) {
    $("banner").textContent = text;
    $("banner").classList.add("shown");
    clearTimeout(this.bannerTimer);
    this.bannerTimer = setTimeout(() => $("banner").classList.remove("shown"), BANNER_MS);
  }

  notice(text) {
    $("notice").hidden = !text;
    $("notice").textContent = text;
  }

  // -- demonstrating --------------------------------------------------------------------------------------------------
  canDemonstrate() { return this.demonstrates && this.role === "player" && this.status && !this.status.finished; }

  takeDemonstration(status) {
    this.status = status;
    this.showStandstill();
    if (this.role !== "player") return;
    this.ask(status.asking && !status.finished);
    this.buildPasses();
    const wanted = status.episodes, done = status.kept;
    const dropped = status.dropped ? `, ${status.dropped} dropped` : "";
    let text = status.recording ? `${done}${wanted ? ` of ${wanted}` : ""} episodes recorded${dropped}` : "Practice: nothing is recorded";
    if (status.finished) text = status.recording ? `Finished: ${done} episodes recorded${dropped}.` : "Finished.";
    else if (status.paused) text += "; paused: keepers hold, nothing is recorded";
    else if (status.dropping) text += "; this one will be dropped";
    else if (status.spoiled) text += "; recording goes on with the next episode";
    $("progress-text").textContent = text;
    $("progress").hidden = !wanted;
    $("progress").max = wanted || 1;
    $("progress").value = Math.min(done, wanted || 0);
    $("pause-recording").firstChild.textContent = status.paused ? "Go on " : "Pause ";
    $("pause-recording").setAttribute("aria-pressed", String(status.paused));
    $("drop").setAttribute("aria-pressed", String(status.dropping));
    $("drop").firstChild.textContent = status.dropping ? "Keep this " : "Drop this ";
    $("drop-last").setAttribute("aria-pressed", String(status.last_dropped));
    $("drop-last").firstChild.textContent = status.last_dropped ? "Keep last " : "Drop last ";
    for (const id of ["pause-recording", "drop", "drop-last", "finish"]) $(id).disabled = status.finished;
    $("drop-last").disabled ||= status.last === null;
  }

  // Nothing was pressed for long: is anybody there?
  ask(asking) {
    if (asking) this.attention.open($("question"));
    else if ($("question").open) $("question").close();
  }

  buildPasses() {
    const actions = this.status.actions;
    if ($("passes").children.length === actions.length) return;
    $("passes").replaceChildren(...actions.map(({ action, name }) => {
      const button = document.createElement("button"), label = document.createElement("span"), cap = document.createElement("kbd");
      button.type = "button";
      button.dataset.action = action;
      button.setAttribute("aria-keyshortcuts", String(action));
      label.textContent = name;
      cap.textContent = String(action);
      button.append(label, cap);
      button.addEventListener("pointerdown", (event) => { if (event.button === 0) this.press(action); });
      button.addEventListener("click", (event) => { if (event.detail === 0) this.press(action); });
      return button;
    }));
  }

  showChoices() {
    const { frame } = this;
    for (const button of $("passes").children) {
      const action = Number(button.dataset.action);
      const choice = frame.choices.find((c) => c.action === action);
      const text = choice ? keyText(choice) : String(action);
      if (button.lastChild.textContent !== text) button.lastChild.textContent = text;
      button.classList.toggle("pending", action !== 0 && frame.pending === action);
      button.classList.toggle("lapsed", action !== 0 && frame.lapsed === action);
      button.classList.toggle("done", frame.seen && frame.action === action && action !== 0);
    }
  }

  showLapse() {
    const { lapsed } = this.frame;
    if (lapsed !== null && this.lapsed === null) this.banner(`Too late: PASS${lapsed} was not played`);
    this.lapsed = lapsed;
  }

  press(action) {
    if (!this.canDemonstrate()) return;
    const actions = this.status.actions.map((known) => known.action);
    if (!actions.includes(action)) {
      this.banner(`There is no ${action} here: ${actions.slice(1).join(" and ")} ${actions.length > 2 ? "pass" : "passes"}, 0 holds`);
      return;
    }
    this.send({ type: "press", value: action });
    const choice = this.frame?.choices.find((c) => c.action === action);
    if (choice) this.pitch.light(choice.mate, performance.now());
  }

  passTo(mate) {
    if (!this.canDemonstrate()) return;
    this.send({ type: "mate", value: mate });
    this.pitch.light(mate, performance.now());
  }

  passTowards(arrow) {
    const choice = this.frame?.choices.find((c) => c.arrow === arrow);
    if (choice) this.passTo(choice.mate);
  }

  record(command) { this.send({ type: "demonstration", value: command }); }
  togglePause() { this.record(this.status.paused ? "resume" : "pause"); }

  askToFinish() {
    const { kept, episodes, recording } = this.status;
    $("confirm-text").textContent = recording
      ? `${kept}${episodes ? ` of ${episodes}` : ""} episodes are recorded. You can go on with the same file later.`
      : "Nothing was recorded: this was practice.";
    $("confirm").returnValue = "";
    this.attention.open($("confirm"));
  }

  // -- playback -------------------------------------------------------------------------------------------------------
  canSeek() { return !this.live && this.role === "player"; }

  takePlayback(status) {
    this.play = status;
    $("position").max = Math.max(0, status.length - 1);
    if (document.activeElement !== $("position") || !this.dragging) $("position").value = status.position;
    const text = status.playing ? "Pause" : "Play";
    $("play-pause").textContent = text;
    $("play-pause").setAttribute("aria-label", text);
    const option = [...$("speed").options].find((o) => Number(o.value) === status.speed);
    if (option) $("speed").value = option.value;
    const clock = seconds(status.position);
    $("clock").textContent = `${clock} s`;
    $("position").setAttribute("aria-valuetext", `${clock} seconds`);
  }

  playback(name, value = 0) { this.send({ type: "playback", name, value }); }
  playOrPause() { this.playback(this.play.playing ? "pause" : "play"); }
  changeSpeed(step) {
    this.play.speed = nextSpeed(this.play.speed, step);
    this.playback("speed", this.play.speed);
  }

  // -- wiring ---------------------------------------------------------------------------------------------------------
  help() { this.attention.open($("help")); }

  wire() {
    history.replaceState(null, "", location.pathname);
    // A button that was clicked gives the keyboard back to the game; one reached by Tab keeps Space and Enter.
    document.addEventListener("click", (event) => {
      if (event.detail > 0 && this.demonstrates) event.target.closest?.("button")?.blur();
    }, true);
    $("help-button").addEventListener("click", () => this.help());
    $("question").addEventListener("close", () => { if (this.status.asking && !this.over) this.record("here"); });
    $("take-seat").addEventListener("click", () => this.send({ type: "seat" }));
    $("pitch").addEventListener("pointerdown", (event) => {
      if (!this.canDemonstrate() || event.button !== 0) return;
      const mate = this.pitch.mateAt(event.clientX, event.clientY);
      if (mate) this.passTo(mate);
    });
    $("pause-recording").addEventListener("click", () => this.togglePause());
    $("drop").addEventListener("click", () => this.record("drop"));
    $("drop-last").addEventListener("click", () => this.record("drop_last"));
    $("finish").addEventListener("click", () => this.askToFinish());
    $("confirm").addEventListener("close", () => { if ($("confirm").returnValue === "finish") this.record("stop"); });
    $("play-pause").addEventListener("click", () => this.playOrPause());
    $("step-back").addEventListener("click", () => this.playback("step", -1));
    $("step-on").addEventListener("click", () => this.playback("step", 1));
    $("previous-episode").addEventListener("click", () => this.playback("episode", -1));
    $("next-episode").addEventListener("click", () => this.playback("episode", 1));
    $("speed").addEventListener("change", () => this.playback("speed", Number($("speed").value)));
    $("position").addEventListener("pointerdown", () => { this.dragging = true; });
    $("position").addEventListener("pointerup", () => { this.dragging = false; });
    $("position").addEventListener("input", () => this.playback("seek", Number($("position").value)));
    $("history").addEventListener("click", (event) => {
      const episode = this.canSeek() ? this.history.at(event.clientX) : null;
      if (episode) this.playback("cycle", episode.start);
    });
  }
}

globalThis.viewer = new Viewer();
