// Score and progress: how long the ball is held now, and what the games before gave.

const $ = (id) => document.getElementById(id);
const CYCLE_S = 0.1; // of the game, at whatever pace it is played

function put(id, text) { if ($(id).textContent !== text) $(id).textContent = text; }

export class Scores {
  constructor(texts) { this.texts = texts; this.cycles = []; this.state = null; this.now = 0; }

  set(episodes) { this.cycles = episodes.map((e) => e.cycles); this.show(); }
  add(episode) { this.cycles.push(episode.cycles); this.show(); }

  running(frame) {
    this.now = Math.max(0, frame.time - frame.start);
    put("duration", this.texts.number(this.now * CYCLE_S));
  }

  seconds(cycles) { return this.texts.number(cycles * CYCLE_S); }

  show() {
    const { texts, cycles } = this, none = texts.say("none");
    const told = (value) => (cycles.length ? texts.say("in_seconds", { seconds: this.seconds(value) }) : none);
    put("duration", this.seconds(this.now));
    put("last", told(cycles[cycles.length - 1]));
    put("best", told(Math.max(...cycles)));
    put("mean", told(cycles.reduce((sum, c) => sum + c, 0) / cycles.length));
  }

  // What is said of a game that has ended.
  said(ending) {
    return this.texts.say("said", { number: this.cycles.length, ending, best: this.seconds(Math.max(...this.cycles)) });
  }

  status(status) {
    const { texts } = this, { kept, episodes, recording } = status;
    const number = Math.min(kept + 1, episodes ?? Infinity), name = recording ? "game" : "practice";
    const dropped = status.dropped ? ` (${texts.say("dropped", { n: status.dropped })})` : "";
    const text = status.finished ? texts.say("finished", { n: kept }) : texts.say(episodes ? `${name}_of` : name, { number, wanted: episodes });
    put("progress-text", text + dropped);
    $("progress").hidden = !episodes;
    $("progress").max = episodes || 1;
    $("progress").value = Math.min(kept, episodes || 0);
    const remark = status.finished ? null : status.paused ? (status.stops ? "paused" : "paused_why") : status.dropping ? "will_drop" : status.spoiled ? "spoiled" : null;
    put("remark", remark ? texts.say(remark) : "");
  }
}
