// Keys of the person who plays. Keys with Ctrl, Alt or Meta stay the browser's; so do those typed into a field of the page.

const ARROWS = new Set(["ArrowLeft", "ArrowUp", "ArrowRight", "ArrowDown"]);

function belongsToControl(event) {
  const node = event.target;
  if (!(node instanceof HTMLElement)) return false;
  if (node.matches("input, select, textarea")) return true;
  return node.matches("button") && (event.key === " " || event.key === "Enter");
}

// viewer: what the page offers, see play.js.
export function listen(viewer) {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || document.querySelector("dialog[open]")) return;
    if (belongsToControl(event)) return;
    const handled = (viewer.replay.shown && viewer.replay.key(event)) || (viewer.canPlay() && play(viewer, event)) || anyone(viewer, event);
    if (handled) event.preventDefault();
  });
}

function play(viewer, event) {
  const key = event.key.toLowerCase();
  const commands = {
    " ": () => viewer.press(0),
    d: () => viewer.record("drop"),
    l: () => viewer.record("drop_last"),
    p: () => viewer.togglePause(),
    f: () => viewer.askToFinish(),
    s: () => viewer.say(),
    enter: () => viewer.toggleTurn(),
  };
  const digit = /^[0-9]$/.test(key);
  if (!digit && !ARROWS.has(event.key) && !(key in commands)) return false;
  if (event.repeat) return true;
  if (digit) viewer.press(Number(key));
  else if (ARROWS.has(event.key)) viewer.passTowards(event.key);
  else commands[key]();
  return true;
}

function anyone(viewer, event) {
  if (event.key === "?") viewer.help();
  else if (event.key.toLowerCase() === "t" && !event.repeat) viewer.theme.next();
  else return false;
  return true;
}
