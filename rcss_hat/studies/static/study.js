// A step to read or to fill in: sends what was filled in as soon as there is a connection, keeps it through a reload,
// and tells whether the page is in sight.

const RETRY_MS = 2000;
const form = document.getElementById("step");
const connection = document.getElementById("connection");
const key = `rcss-hat ${location.pathname} ${form?.elements.step.value}`;

function store(text) {
  try { text === null ? sessionStorage.removeItem(key) : sessionStorage.setItem(key, text); } catch { /* then nothing is kept */ }
}

function stored() {
  try { return JSON.parse(sessionStorage.getItem(key) ?? "[]"); } catch { return []; }
}

function keep() {
  store(JSON.stringify([...new FormData(form)].filter(([name, value]) => name !== "step" && typeof value === "string")));
}

function restore() {
  for (const [name, value] of stored()) {
    for (const field of form.querySelectorAll(`[name="${CSS.escape(name)}"]`)) {
      if (field.type === "radio" || field.type === "checkbox") field.checked ||= field.value === value;
      else if (!field.value) field.value = value;
    }
  }
}

const pause = (ms) => new Promise((done) => setTimeout(done, ms));

async function reachable() {
  try { return (await fetch("alive", { cache: "no-store" })).ok; } catch { return false; }
}

// A form that is sent without a connection would be lost in the browser's own page of errors.
async function submit(event) {
  event.preventDefault();
  const button = form.querySelector("button.go");
  button.disabled = true;
  while (!(await reachable())) {
    connection.textContent = form.dataset.offline;
    await pause(RETRY_MS);
  }
  connection.textContent = "";
  form.submit();
}

let looking = null;

function tellLook() {
  const now = !document.hidden && document.hasFocus();
  if (now === looking) return;
  looking = now;
  fetch("events", { method: "POST", keepalive: true, body: JSON.stringify({ look: now }) }).catch(() => { looking = null; });
}

if (form) {
  restore();
  form.addEventListener("input", keep);
  form.addEventListener("change", keep);
  form.addEventListener("submit", submit);
  addEventListener("pageshow", () => { form.querySelector("button.go").disabled = false; });
}
document.addEventListener("visibilitychange", tellLook);
addEventListener("focus", tellLook);
addEventListener("blur", tellLook);
tellLook();
