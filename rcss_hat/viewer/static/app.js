// The page: takes messages from the viewer's server, shows them, and sends back what the person does.

import { Facts, History, ending, playerName, seconds } from "./panels.js";
import { Pitch, keyText } from "./pitch.js";
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
    this.pitch = new Pitch($("pitch"));
    this.facts = new Facts();
    this.history = new History($("history"), this.pitch);
    this.theme = new Theme($("theme"), () => { this.pitch.readColours(); this.history.draw(); });
    listen(this);
    this.wire();
    this.connect();
    const draw = (now) => { this.pitch.draw(now); requestAnimationFrame(draw); };
    requestAnimationFrame(draw);
  }

  // -- connection -----------------------------------------------------------------------------------------------------
  connect() {
    this.socket = new WebSocket(`ws://${location.host}/socket`);
    this.socket.addEventListener("open", () => this.connection("on", "connected"));
    this.socket.addEventListener("message", (event) => this.take(JSON.parse(event.data)));
    this.socket.addEventListener("close", (event) => {
      this.connection("off", event.code === 1001 ? "closed" : "not connected");
      setTimeout(() => this.connect(), RETRY_MS);
    });
  }

  connection(state, text) {
    $("connection").dataset.state = state;
    $("connection").querySelector(".text").textContent = text;
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  take(message) {
    if (message.type === "frame") this.takeFrame(message.frame);
    else if (message.type === "playback") this.takePlayback(message);
    else if (message.type === "demonstration") this.takeDemonstration(message);
    else if (message.type === "episode") this.takeEpisode(message.episode);
    else if (message.type === "episodes") this.history.set(message.episodes);
    else if (message.type === "setup") this.takeSetup(message);
    else if (message.type === "hello") this.takeHello(message);
    else if (message.type === "notice") this.notice(message.text);
    else if (message.type === "refused") this.banner(message.text);
  }

  takeHello(message) {
    this.role = message.role;
    this.demonstrates = message.demonstrate;
    const play = this.demonstrates && this.role === "player";
    this.pitch.playing = play;
    $("play").hidden = !play;
    $("help-demonstrate").hidden = !play;
    document.querySelector("main").classList.toggle("playing", play);
    this.connection("on", this.role === "player" ? (play ? "you play" : "connected") : "watching");
    this.arrange();
  }

  takeSetup(message) {
    this.setup = message.setup;
    this.live = message.live;
    this.pitch.setSetup(this.setup);
    $("title").textContent = this.setup.title;
    document.title = `${this.setup.title} \u2013 rcss-hat`;
    $("legend-left").textContent = this.setup.teams[0];
    $("legend-right").textContent = this.setup.teams[1];
    this.arrange();
  }

  arrange() {
    const seek = this.canSeek();
    $("transport").hidden = !seek;
    $("help-playback").hidden = !seek;
    document.body.classList.toggle("seekable", seek);
  }

  takeFrame(frame) {
    this.frame = frame;
    this.frames += 1;
    if (!this.setup) return;
    const now = performance.now();
    this.pitch.push(frame, now, this.live ? 1 : this.play.speed);
    this.facts.show(frame, this.setup);
    if (!this.live) this.history.mark(frame.episode);
    if (this.pitch.playing) this.showChoices();
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
    if (this.role !== "player") return;
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
      button.classList.toggle("done", frame.seen && frame.action === action && action !== 0);
    }
  }

  press(action) {
    if (!this.canDemonstrate()) return;
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
    $("confirm").showModal();
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
  help() { $("help").showModal(); }

  wire() {
    history.replaceState(null, "", location.pathname);
    $("help-button").addEventListener("click", () => this.help());
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
