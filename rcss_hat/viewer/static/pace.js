// How long the page waits from one picture to the next, told now and then to whoever keeps a log.

const EVERY_MS = 5000, MOST = 400;

export class Pace {
  constructor(tell) {
    this.tell = tell;
    this.intervals = [];
    this.before = null;
    setInterval(() => this.flush(), EVERY_MS);
  }

  // A picture has come; when the game stands still, there is nothing to wait for.
  picture(now, standing) {
    if (!standing && this.before !== null && this.intervals.length < MOST) this.intervals.push(Math.round(now - this.before));
    this.before = standing ? null : now;
  }

  flush() {
    if (this.intervals.length) this.tell({ type: "pace", intervals: this.intervals });
    this.intervals = [];
  }
}
