// The connection to the program that serves the page; comes back by itself. Addresses are relative: a proxy may stand between.

const REPLACED = 4001; // the code with which such a page is closed
const FIRST_MS = 500, LONGEST_MS = 5000;
const here = location.href.split(/[?#]/)[0];

export class Link {
  // take: gets every message; changed: told "on", "off" (trying again), "gone" (this address is no longer valid) or "replaced"
  // (somebody has opened another page of the same place; to come back by itself would throw that one out).
  constructor(take, changed) {
    this.take = take;
    this.changed = changed;
    this.pause = FIRST_MS;
    this.over = false;
    this.connect();
    addEventListener("online", () => this.again());
  }

  connect() {
    clearTimeout(this.timer);
    const socket = new WebSocket(new URL("socket", here).href.replace(/^http/, "ws"));
    this.socket = socket;
    let opened = false;
    socket.addEventListener("open", () => { opened = true; this.pause = FIRST_MS; this.changed("on"); });
    socket.addEventListener("message", (event) => this.take(JSON.parse(event.data)));
    socket.addEventListener("close", (event) => {
      if (this.over || socket !== this.socket) return;
      if (event.code === REPLACED) { this.end(); this.changed("replaced"); return; }
      this.changed("off");
      this.timer = setTimeout(() => (opened ? this.connect() : this.look()), this.pause);
      this.pause = Math.min(2 * this.pause, LONGEST_MS);
    });
  }

  // Nobody answers: is the server gone for now, or the page's place elsewhere?
  async look() {
    const answer = await fetch(here, { redirect: "manual", cache: "no-store" }).catch(() => null);
    if (answer?.status === 403) this.changed("gone");
    else if (answer && (answer.type === "opaqueredirect" || answer.status === 404 || answer.status === 410)) location.reload();
    else this.connect();
  }

  again() { if (!this.over && this.socket.readyState === WebSocket.CLOSED) this.connect(); }

  get open() { return this.socket.readyState === WebSocket.OPEN; }

  send(message) { if (this.open) this.socket.send(JSON.stringify(message)); }

  // It is over: whatever happens to the connection now means nothing.
  end() { this.over = true; clearTimeout(this.timer); }
}
