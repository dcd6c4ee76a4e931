// The picture: region, players, ball, and what the keys mean. World axes as in the server: x right, y down, metres.

const MARGIN = 2.5;          // metres around the region
const TELEPORT = 3.0;        // farther than this within a frame is a reset, not a motion
const TRAIL = 12;            // ball positions kept
const SYMBOLS = { ArrowLeft: "\u2190", ArrowUp: "\u2191", ArrowRight: "\u2192", ArrowDown: "\u2193" };
const radians = (degrees) => degrees * Math.PI / 180;
const mix = (a, b, t) => a + (b - a) * t;

export class Pitch {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.setup = { length: 20, width: 20, keepaway: true, reach: 1.085, step_s: 0.1 };
    this.current = null;
    this.previous = null;
    this.arrived = 0;
    this.span = 100;
    this.trail = [];
    this.flash = null;
    this.playing = false;   // the person in front of the page decides
    this.replaying = false; // what is shown has been played
    this.numbers = true;    // of players; a page on which numbers are keys has no others
    this.arrows = true;     // arrow keys, beside numbers
    this.words = { late: "too late" };
    this.pictures = 0;
    this.scale = 1;
    this.still = matchMedia("(prefers-reduced-motion: reduce)");
    this.readColours();
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  readColours() {
    const style = getComputedStyle(document.documentElement);
    this.colours = new Proxy({}, { get: (known, name) => known[name] ??= style.getPropertyValue(`--${name}`).trim() });
  }

  setSetup(setup) {
    this.setup = setup;
    const ratio = (setup.length + 2 * MARGIN) / (setup.width + 2 * MARGIN);
    document.documentElement.style.setProperty("--ratio", ratio.toFixed(4));
    this.current = this.previous = null;
    this.trail = [];
    this.resize();
  }

  resize() {
    const box = this.canvas.getBoundingClientRect();
    const density = window.devicePixelRatio || 1;
    this.canvas.width = Math.max(1, Math.round(box.width * density));
    this.canvas.height = Math.max(1, Math.round(box.height * density));
    this.scale = this.canvas.width / (this.setup.length + 2 * MARGIN);
    this.density = density;
  }

  // A new frame; speed: times real time, so that motion between two frames takes as long as between their arrivals.
  push(frame, now, speed) {
    const before = this.current;
    if (before && (frame.time < before.time || frame.time - before.time > 20)) this.trail = [];
    this.previous = before && frame.time > before.time && frame.time - before.time <= 3 * Math.max(1, speed) ? before : null;
    const expected = this.setup.step_s * 1000 / speed * (before ? frame.time - before.time : 1);
    this.span = Math.min(Math.max(expected, 1), 150) * (this.playing ? 0.5 : 1);
    this.current = frame;
    this.arrived = now;
    this.flash = null;
    const last = this.trail[this.trail.length - 1];
    if (last && Math.hypot(last[0] - frame.ball[0], last[1] - frame.ball[1]) > TELEPORT * 1.5) this.trail = [];
    this.trail.push([frame.ball[0], frame.ball[1]]);
    if (this.trail.length > TRAIL) this.trail.shift();
  }

  // Begin anew with the next frame.
  forget() { this.current = this.previous = null; this.trail = []; }

  // Show which pass a key asks for, until the next frame tells what became of it.
  light(mate, now) { this.flash = { from: this.current?.keepers?.[0], mate, until: now + 450 }; }

  x(metres) { return (metres + this.setup.length / 2 + MARGIN) * this.scale; }
  y(metres) { return (metres + this.setup.width / 2 + MARGIN) * this.scale; }
  radius() { return Math.max(0.55 * this.scale, 8 * this.density); }

  // Where everybody is at this moment, between the last two frames.
  places(now) {
    const t = this.still.matches || !this.previous ? 1 : Math.min((now - this.arrived) / this.span, 1);
    const old = new Map((this.previous?.players ?? []).map((p) => [p.id, p]));
    const players = this.current.players.map((p) => {
      const q = old.get(p.id);
      if (!q || t === 1 || Math.hypot(p.x - q.x, p.y - q.y) > TELEPORT) return p;
      const turn = ((p.body - q.body + 540) % 360) - 180;
      return { ...p, x: mix(q.x, p.x, t), y: mix(q.y, p.y, t), body: q.body + turn * t, neck: mix(q.neck, p.neck, t) };
    });
    const b = this.current.ball, a = this.previous?.ball;
    const jumped = !a || Math.hypot(b[0] - a[0], b[1] - a[1]) > TELEPORT * 1.5;
    return { players, ball: t === 1 || jumped ? b : [mix(a[0], b[0], t), mix(a[1], b[1], t)] };
  }

  draw(now) {
    const { context: c, canvas } = this;
    c.fillStyle = this.colours.pitch;
    c.fillRect(0, 0, canvas.width, canvas.height);
    this.drawGround();
    this.pictures += 1;
    if (!this.current) return;
    const { players, ball } = this.places(now);
    const holder = players.find((p) => p.id === this.current.holder);
    this.drawTrail();
    if (holder) this.circle(holder.x, holder.y, this.setup.reach * this.scale, this.colours.reach);
    if (this.playing || this.replaying) this.drawPasses(players, now);
    // Whoever has the ball is on top, then keepers.
    const layer = (player) => (player === holder ? 2 : player.side === "l" ? 1 : 0);
    for (const player of [...players].sort((a, b) => layer(a) - layer(b))) this.drawPlayer(player, player === holder);
    this.drawBall(ball);
    if (this.playing || this.replaying) this.drawKeys(players, now);
  }

  drawGround() {
    const { context: c, setup } = this;
    const x = this.x(-setup.length / 2), y = this.y(-setup.width / 2);
    const width = setup.length * this.scale, height = setup.width * this.scale;
    c.fillStyle = this.colours.region;
    c.fillRect(x, y, width, height);
    c.strokeStyle = this.colours.grid;
    c.lineWidth = this.density;
    c.beginPath();
    for (let m = 5; m < setup.length; m += 5) { c.moveTo(x + m * this.scale, y); c.lineTo(x + m * this.scale, y + height); }
    for (let m = 5; m < setup.width; m += 5) { c.moveTo(x, y + m * this.scale); c.lineTo(x + width, y + m * this.scale); }
    c.stroke();
    c.strokeStyle = this.colours.edge;
    c.lineWidth = 2 * this.density;
    c.strokeRect(x, y, width, height);
    if (!setup.keepaway) {
      c.beginPath();
      c.moveTo(this.x(0), y);
      c.lineTo(this.x(0), y + height);
      c.moveTo(this.x(9.15), this.y(0));
      c.arc(this.x(0), this.y(0), 9.15 * this.scale, 0, 2 * Math.PI);
      c.stroke();
      for (const side of [-1, 1]) {
        const goal = side * setup.length / 2;
        c.strokeRect(Math.min(this.x(goal), this.x(goal - side * 16.5)), this.y(-20.16), 16.5 * this.scale, 40.32 * this.scale);
      }
    }
  }

  drawTrail() {
    const { context: c } = this;
    c.fillStyle = this.colours.trail;
    this.trail.slice(0, -1).forEach(([x, y], index) => {
      c.globalAlpha = (index + 1) / this.trail.length;
      this.circle(x, y, Math.max(0.11 * this.scale, 1.5 * this.density), this.colours.trail);
    });
    c.globalAlpha = 1;
  }

  circle(x, y, radius, fill) {
    const c = this.context;
    c.beginPath();
    c.arc(this.x(x), this.y(y), radius, 0, 2 * Math.PI);
    c.fillStyle = fill;
    c.fill();
  }

  drawPlayer(player, holds) {
    const { context: c, density } = this;
    const x = this.x(player.x), y = this.y(player.y), r = this.radius();
    const colour = player.side === "l" ? this.colours.keeper : this.colours.taker;
    const body = radians(player.body), face = radians(player.body + player.neck);
    c.strokeStyle = colour;
    c.fillStyle = colour;
    c.lineCap = "round";
    // The nose points where the body does; the thin line is where the player looks.
    c.beginPath();
    c.moveTo(x + 1.55 * r * Math.cos(body), y + 1.55 * r * Math.sin(body));
    c.lineTo(x + r * Math.cos(body + 0.55), y + r * Math.sin(body + 0.55));
    c.lineTo(x + r * Math.cos(body - 0.55), y + r * Math.sin(body - 0.55));
    c.fill();
    c.lineWidth = 1.5 * density;
    c.beginPath();
    c.moveTo(x + 1.15 * r * Math.cos(face), y + 1.15 * r * Math.sin(face));
    c.lineTo(x + 1.75 * r * Math.cos(face), y + 1.75 * r * Math.sin(face));
    c.stroke();
    c.beginPath();
    if (player.side === "l") c.arc(x, y, r, 0, 2 * Math.PI);
    else c.roundRect(x - 0.9 * r, y - 0.9 * r, 1.8 * r, 1.8 * r, 0.35 * r);
    c.fillStyle = holds ? this.colours.region : colour;
    c.fill();
    c.lineWidth = (holds ? 3.5 : 1.5) * density;
    c.strokeStyle = colour;
    c.stroke();
    c.fillStyle = holds ? colour : this.colours["on-player"];
    c.font = `600 ${Math.round(1.05 * r)}px system-ui, sans-serif`;
    c.textAlign = "center";
    c.textBaseline = "middle";
    if (this.numbers) c.fillText(player.unum, x, y + 0.06 * r);
  }

  drawBall([bx, by]) {
    const { context: c, density } = this;
    const r = Math.max(0.26 * this.scale, 4.5 * density);
    c.lineWidth = 1.75 * density;
    c.strokeStyle = this.colours["ball-edge"];
    this.circle(bx, by, r, this.colours.ball);
    c.stroke();
  }

  // Lines from the keeper with the ball to those he can pass to; faint while the ball is on its way to him.
  drawPasses(players, now) {
    const { context: c, density, current } = this;
    if (!this.canPlay()) return;
    const where = new Map(players.map((p) => [p.id, p]));
    const line = (from, to, colour, width, alpha, dash) => {
      if (!from || !to) return;
      c.globalAlpha = alpha;
      c.strokeStyle = colour;
      c.lineWidth = width * density;
      c.setLineDash(dash.map((length) => length * density));
      c.beginPath();
      c.moveTo(this.x(from.x), this.y(from.y));
      c.lineTo(this.x(to.x), this.y(to.y));
      c.stroke();
    };
    const from = where.get(current.keepers[0]);
    for (const { action, mate } of current.choices) {
      if (action === current.pending) line(from, where.get(mate), this.colours.want, 4, 0.95, []);
      else if (action === current.lapsed) line(from, where.get(mate), this.colours.bad, 3, 0.8, [2, 6]);
      else line(from, where.get(mate), this.colours.keeper, 2, this.theirs() ? 0.5 : 0.2, [6, 7]);
    }
    if (this.flash && now < this.flash.until) {
      line(where.get(this.flash.from), where.get(this.flash.mate), this.colours.keeper, 4, 0.95, []);
    }
    c.setLineDash([]);
    c.globalAlpha = 1;
  }

  drawKeys(players, now) {
    const { context: c, density, current } = this;
    if (!this.canPlay()) return;
    const size = Math.max(12 * density, 0.62 * this.scale);
    c.font = `700 ${Math.round(size)}px system-ui, sans-serif`;
    c.textAlign = "center";
    c.textBaseline = "middle";
    for (const choice of current.choices) {
      const to = players.find((p) => p.id === choice.mate);
      if (!to) continue;
      const lapsed = choice.action === current.lapsed, lit = lapsed || this.isLit(choice);
      const text = lapsed ? this.words.late : this.keyText(choice), bright = lapsed ? this.colours.bad : this.colours.want;
      const width = c.measureText(text).width + size, height = 1.6 * size;
      const away = this.radius() + height * 0.75 + 3 * density;
      const above = this.y(to.y) - away - height / 2 > 2;
      const x = Math.min(Math.max(this.x(to.x), width / 2 + 2), this.canvas.width - width / 2 - 2);
      const y = this.y(to.y) + (above ? -away : away);
      c.globalAlpha = this.theirs() || lit || this.isAsked(choice, now) ? 1 : 0.45;
      c.beginPath();
      c.roundRect(x - width / 2, y - height / 2, width, height, 0.4 * size);
      c.fillStyle = lit ? bright : this.colours.key;
      c.fill();
      c.lineWidth = 1.5 * density;
      c.strokeStyle = lit ? bright : this.colours.keeper;
      c.stroke();
      c.fillStyle = lit ? this.colours["accent-ink"] : this.colours["key-ink"];
      c.fillText(text, x, y + 0.05 * size);
    }
    c.globalAlpha = 1;
  }

  keyText(choice) { return choice.arrow && this.arrows ? `${choice.action} ${SYMBOLS[choice.arrow]}` : `${choice.action}`; }

  canPlay() { return this.current.mode === "play_on" && this.current.keepers; }
  theirs() { return this.current.holder !== null && this.current.holder === this.current.keepers?.[0]; }
  isLit(choice) { return this.current.pending === choice.action; }
  isAsked(choice, now) { return this.flash && this.flash.mate === choice.mate && now < this.flash.until; }

  // The team mate at a place on the screen, or null.
  mateAt(clientX, clientY) {
    if (!this.current) return null;
    const box = this.canvas.getBoundingClientRect();
    const factor = this.canvas.width / box.width;
    const x = (clientX - box.left) * factor, y = (clientY - box.top) * factor;
    let best = null, nearest = Math.max(3.2 * this.scale, 34 * this.density);
    for (const player of this.places(performance.now()).players) {
      if (!this.current.choices.some((choice) => choice.mate === player.id)) continue;
      const distance = Math.hypot(this.x(player.x) - x, this.y(player.y) - y);
      if (distance < nearest) { best = player.id; nearest = distance; }
    }
    return best;
  }
}
