// Buttons that act while the finger is still down, but not when a swipe begins on them.

const SETTLES_MS = 60, FAR_PX = 10;

export function listenToFinger(button, act) {
  let waiting = null, start = null;
  const cancel = () => { clearTimeout(waiting); waiting = start = null; };
  const now = () => { if (start) { cancel(); act(); } };
  button.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    if (event.pointerType !== "touch") { act(); return; }
    start = [event.clientX, event.clientY];
    waiting = setTimeout(now, SETTLES_MS);
  });
  button.addEventListener("pointermove", (event) => {
    if (start && Math.hypot(event.clientX - start[0], event.clientY - start[1]) > FAR_PX) cancel();
  });
  button.addEventListener("pointerup", now);
  button.addEventListener("pointercancel", cancel);
  // By keyboard, or by a program that reads the screen.
  button.addEventListener("click", (event) => { if (event.detail === 0) act(); });
}
