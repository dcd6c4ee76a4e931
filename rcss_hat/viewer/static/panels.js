// The figures beside the picture.

const MEAN_OF = 20;
const $ = (id) => document.getElementById(id);
const REASONS = { o: "ball out", t: "ball taken", "?": "ended" };
const CYCLE_S = 0.1; // of the game, at whatever pace it is played
export const seconds = (cycles) => (cycles * CYCLE_S).toFixed(1);

function setText(node, text) { if (node.textContent !== text) node.textContent = text; }

export function playerName(id, setup) {
  if (!setup.keepaway) return `${id[0] === "l" ? setup.teams[0] : setup.teams[1]} ${id.slice(1)}`;
  return `${id[0] === "l" ? "keeper" : "taker"} ${id.slice(1)}`;
}

// Names of the state variables in the order of the players' code: see rcss_hat/keepaway/state.py.
export function variableNames(keepers, takers) {
  const mates = Array.from({ length: keepers - 1 }, (_, k) => `K${k + 2}`);
  const others = Array.from({ length: takers }, (_, k) => `T${k + 1}`);
  return [
    "K1 to centre",
    ...mates.map((k) => `K1 to ${k}`), ...others.map((t) => `K1 to ${t}`),
    ...mates.map((k) => `${k} to centre`), ...others.map((t) => `${t} to centre`),
    ...mates.map((k) => `${k} to nearest taker`), ...mates.map((k) => `free angle to ${k}`),
  ];
}

export class Facts {
  constructor() { this.setup = null; this.shape = ""; }

  show(frame, setup) {
    setText($("episode"), setup.keepaway ? (frame.episode ? String(frame.episode) : "under way") : "none: no Keepaway");
    setText($("holder"), frame.holder ? playerName(frame.holder, setup) : "loose");
    setText($("mode"), frame.mode.replaceAll("_", " "));
    setText($("cycle"), String(frame.time));
    this.showMind(frame, setup);
  }

  showMind(frame, setup) {
    const mind = $("mind");
    mind.hidden = !frame.state;
    if (!frame.state) return;
    const n = frame.keepers.length, m = frame.takers.length, shape = `${n}v${m}`;
    if (shape !== this.shape) this.build(shape, n, m);
    const k1 = playerName(frame.keepers[0], setup);
    mind.classList.toggle("loose", frame.holder !== frame.keepers[0]);
    const action = frame.seen && frame.action !== null ? `: ${frame.action === 0 ? "Hold" : `PASS${frame.action}`}` : "";
    setText($("mind-title"), `K1 = ${k1}${frame.holder === frame.keepers[0] ? " with the ball" : ", nearest to the ball"}${action}`);
    const angles = frame.state.length - (n - 1);
    frame.state.forEach((value, k) => setText(this.cells[k], `${value.toFixed(k < angles ? 1 : 0)} ${k < angles ? "m" : "\u00b0"}`));
    setText($("state-source"), frame.seen ? "As the keeper perceives it." : "From true positions; the keeper's own view is less exact.");
    this.showValues(frame.values);
  }

  build(shape, n, m) {
    this.shape = shape;
    const rows = variableNames(n, m).map((name, k) => {
      const row = document.createElement("tr");
      for (const [tag, text] of [["th", String(k)], ["td", name], ["td", ""]]) {
        const cell = document.createElement(tag);
        cell.textContent = text;
        if (tag === "th") { cell.scope = "row"; cell.title = `state_${k}`; }
        row.append(cell);
      }
      return row;
    });
    $("state").tBodies[0].replaceChildren(...rows);
    this.cells = rows.map((row) => row.lastChild);
  }

  showValues(values) {
    const box = $("values");
    box.hidden = !values;
    if (!values) return;
    if (box.children.length !== values.length) {
      box.replaceChildren(...values.map((_, a) => {
        const row = document.createElement("div");
        row.className = "value";
        const name = document.createElement("span"), bar = document.createElement("i"), number = document.createElement("b");
        name.textContent = a === 0 ? "Hold" : `PASS${a}`;
        bar.append(document.createElement("span"));
        row.append(name, bar, number);
        return row;
      }));
    }
    const top = Math.max(...values), low = Math.min(0, ...values);
    values.forEach((value, a) => {
      const [, bar, number] = box.children[a].children;
      box.children[a].classList.toggle("best", value === top);
      bar.firstChild.style.transform = `scaleX(${top > low ? (value - low) / (top - low) : 0})`;
      setText(number, value.toFixed(2));
    });
  }
}

export class History {
  constructor(canvas, pitch) {
    this.canvas = canvas;
    this.pitch = pitch;
    this.episodes = [];
    this.bars = [];
    this.current = 0;
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  set(episodes) { this.episodes = [...episodes]; this.draw(); }
  add(episode) { this.episodes.push(episode); this.draw(); }
  // Mark the episode that is shown, where a recording can be sought.
  mark(number) { if (number !== this.current) { this.current = number; this.draw(); } }

  draw() {
    const { canvas, episodes } = this, c = canvas.getContext("2d");
    const density = window.devicePixelRatio || 1, box = canvas.getBoundingClientRect();
    canvas.width = Math.max(1, Math.round(box.width * density));
    canvas.height = Math.max(1, Math.round(box.height * density));
    const width = canvas.width, height = canvas.height, colours = this.pitch.colours;
    const room = Math.max(1, Math.floor((width - 28 * density) / (5 * density)));
    const first = Math.max(0, episodes.length - room), shown = episodes.slice(first);
    const top = Math.max(5, ...shown.map((e) => e.cycles * CYCLE_S));
    const left = 26 * density, floor = height - 3 * density, unit = (floor - 10 * density) / top;
    c.font = `${10 * density}px system-ui, sans-serif`;
    c.textAlign = "right";
    c.textBaseline = "middle";
    c.lineWidth = density;
    const step = top > 80 ? 40 : top > 40 ? 20 : top > 16 ? 10 : 5;
    for (let s = 0; s <= top; s += step) {
      const y = Math.round(floor - s * unit) + 0.5;
      c.strokeStyle = colours.line;
      c.beginPath();
      c.moveTo(left, y);
      c.lineTo(width, y);
      c.stroke();
      c.fillStyle = colours.soft;
      c.fillText(`${s} s`, left - 4 * density, Math.min(y, height - 6 * density));
    }
    const pitch = Math.min((width - left) / Math.max(shown.length, 1), 18 * density);
    c.lineWidth = 2 * density;
    this.bars = shown.map((e, k) => {
      const x = left + k * pitch + pitch * 0.12;
      c.fillStyle = e.reason === "t" ? colours.taker : colours.keeper;
      c.fillRect(x, floor - e.cycles * CYCLE_S * unit, pitch * 0.76, Math.max(e.cycles * CYCLE_S * unit, density));
      if (e.number === this.current) {
        c.strokeStyle = colours.ink;
        c.strokeRect(x, floor - e.cycles * CYCLE_S * unit, pitch * 0.76, Math.max(e.cycles * CYCLE_S * unit, density));
      }
      return { from: (left + k * pitch) / density, to: (left + (k + 1) * pitch) / density, episode: e };
    });
    c.strokeStyle = colours.ink;
    c.lineWidth = 2 * density;
    c.lineJoin = "round";
    c.beginPath();
    shown.forEach((_, k) => {
      const window_ = episodes.slice(Math.max(0, first + k + 1 - MEAN_OF), first + k + 1);
      const mean = window_.reduce((sum, e) => sum + e.cycles, 0) / window_.length * CYCLE_S;
      const x = left + (k + 0.5) * pitch, y = floor - mean * unit;
      if (k === 0) c.moveTo(x, y); else c.lineTo(x, y);
    });
    c.stroke();
    this.describe();
  }

  describe() {
    const { episodes } = this;
    if (!episodes.length) { setText($("history-text"), "None has ended yet."); return; }
    const mean = episodes.reduce((sum, e) => sum + e.cycles, 0) / episodes.length * CYCLE_S;
    const last = episodes[episodes.length - 1];
    const text = `${episodes.length} ended, mean ${mean.toFixed(2)} s; last ${seconds(last.cycles)} s, ${REASONS[last.reason]}`;
    setText($("history-text"), text);
    this.canvas.setAttribute("aria-label", `Durations of the episodes: ${text}`);
  }

  // The episode whose bar is at a place on the screen, or null.
  at(clientX) {
    const x = clientX - this.canvas.getBoundingClientRect().left;
    return this.bars.find((bar) => x >= bar.from && x < bar.to)?.episode ?? null;
  }
}

export function ending(episode) {
  const reason = { o: "Ball out", t: "Ball taken", "?": "Ended" }[episode.reason];
  return `${reason} after ${seconds(episode.cycles)} s`;
}
