// The page of those who watch: takes messages from the viewer's server, shows them, and sends back what the person does.

import { Facts, History, ending, playerName, seconds } from "./panels.js";
import { Pitch } from "./pitch.js";
import { listen, nextSpeed } from "./keys.js";
import { Theme } from "./theme.js";

const $ = (id) => document.getElementById(id);
const BANNER_MS = 1600;
const RETRY_MS = 1000;
const DESCRIBE_MS = 1000;

class Viewer {
  constructor() {
    this.role = "watcher";
    this.live = true;
    this.setup = null;
    this.frame = null;
    this.frames = 0;
    this.play = { playing: false, speed: 1, position: 0, length: 0, complete: false };
    this.described = -Infinity;
    this.seat = "taken";
    this.pitch = new Pitch($("pitch"));
    this.facts = new Facts();
    this.history = new History($("history"), this.pitch);
    this.theme = new Theme($("theme"), () => { this.pitch.readColours(); this.history.draw(); });
    listen(this);
    this.wire();
    document.addEventListener("visibilitychange", () => this.tellLook());
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
      this.connection("off", closed ? "closed" : "not connected");
      if (!closed) setTimeout(() => this.connect(), RETRY_MS);
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
    else if (message.type === "episode") this.takeEpisode(message.episode);
    else if (message.type === "episodes") this.history.set(message.episodes);
    else if (message.type === "setup") this.takeSetup(message);
    else if (message.type === "hello") this.takeRole(message.role);
    else if (message.type === "seat") this.takeSeat(message);
    else if (message.type === "notice") this.notice(message.text);
    else if (message.type === "refused") this.banner(message.text);
  }

  takeRole(role) {
    this.role = role;
    this.connection("on", role === "player" ? "connected" : "watching");
    this.arrange();
  }

  // Who steers, and how to steer instead.
  takeSeat({ role, state }) {
    if (role !== this.role) this.takeRole(role);
    $("seat-text").textContent = {
      taken: "Another browser steers: the one that opened the link before. When its page is closed or left, a button appears here.",
      left: "The browser that steers is open, but nobody looks at it.",
      free: "Nobody steers: the page of the browser that did is closed.",
    }[state];
    $("take-seat").hidden = state === "taken";
    this.arrange();
  }

  tellLook() { this.send({ type: "look", value: !document.hidden }); }

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
    const watching = this.role !== "player";
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
    $("duration").textContent = seconds(Math.max(0, frame.time - frame.start));
    if (!this.live) this.history.mark(frame.episode);
    if (now - this.described > DESCRIBE_MS || (!this.live && !this.play.playing)) this.describe(now);
  }

  describe(now) {
    this.described = now;
    const { frame, setup } = this;
    const holder = frame.holder ? `${playerName(frame.holder, setup)} has the ball` : "the ball is loose";
    const time = seconds(frame.time - frame.start);
    $("pitch").setAttribute("aria-label", `Episode ${frame.episode}, ${time} seconds; ${holder}`);
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
    $("take-seat").addEventListener("click", () => this.send({ type: "seat" }));
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
