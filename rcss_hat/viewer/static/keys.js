// Keys to commands. Keys with Ctrl, Alt or Meta stay the browser's; so do those typed into a field of the page.

const SPEEDS = [0.25, 0.5, 1, 2, 5, 20, 100];

function belongsToControl(event) {
  const node = event.target;
  if (!(node instanceof HTMLElement)) return false;
  if (node.matches("input, select, textarea")) return true;
  return node.matches("button") && (event.key === " " || event.key === "Enter");
}

export function nextSpeed(speed, step) {
  const index = SPEEDS.findIndex((s) => s >= speed - 1e-9);
  return SPEEDS[Math.min(Math.max((index < 0 ? SPEEDS.length - 1 : index) + step, 0), SPEEDS.length - 1)];
}

// viewer: what the page offers, see app.js.
export function listen(viewer) {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || document.querySelector("dialog[open]")) return;
    if (belongsToControl(event)) return;
    const handled = (viewer.canSeek() && seek(viewer, event)) || anyone(viewer, event);
    if (handled) event.preventDefault();
  });
}

function seek(viewer, event) {
  const stride = event.shiftKey ? 10 : 1;
  const commands = {
    " ": () => viewer.playOrPause(),
    ArrowLeft: () => viewer.playback("step", -stride),
    ArrowRight: () => viewer.playback("step", stride),
    Home: () => viewer.playback("seek", 0),
    End: () => viewer.playback("seek", 1e9),
    "[": () => viewer.playback("episode", -1),
    "]": () => viewer.playback("episode", 1),
    "+": () => viewer.changeSpeed(1),
    "=": () => viewer.changeSpeed(1),
    "-": () => viewer.changeSpeed(-1),
  };
  if (!(event.key in commands)) return false;
  if (!(event.repeat && event.key === " ")) commands[event.key]();
  return true;
}

function anyone(viewer, event) {
  if (event.key === "?") viewer.help();
  else if (event.key.toLowerCase() === "t" && !event.repeat) viewer.theme.next();
  else return false;
  return true;
}
