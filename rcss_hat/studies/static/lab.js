// The experimenter's page: asks the server now and then, and does what she wants.

const EVERY_MS = 2000;
const GAMES = 5;
const $ = (id) => document.getElementById(id);
const seconds = (value) => (value === null || value === undefined ? "" : `${value.toFixed(1)} s`);

function cell(text, name = "td") {
  const node = document.createElement(name);
  node.textContent = text;
  if (name === "th") node.scope = "row";
  return node;
}

function button(text, label, act) {
  const node = document.createElement("button");
  node.type = "button";
  node.textContent = text;
  node.setAttribute("aria-label", label);
  node.addEventListener("click", act);
  return node;
}

async function act(action, entry, games = null) {
  const answer = await fetch("do", { method: "POST", body: JSON.stringify({ action, place: entry.place, games }) });
  const { done, why } = await answer.json();
  $("told").textContent = done ? `${entry.name}: done.` : `${entry.name}: ${why}.`;
  await update();
}

function sure(title, text, then) {
  $("sure-title").textContent = title;
  $("sure-text").textContent = text;
  $("sure").returnValue = "no";
  $("sure").onclose = () => { if ($("sure").returnValue === "yes") then(); };
  $("sure").showModal();
}

function buttons(entry) {
  const box = document.createElement("td");
  const running = entry.state === "here" || entry.state === "away";
  if (running && entry.games !== null) box.append(button(`+${GAMES} games`, `${GAMES} games more for ${entry.name}`, () => act("extend", entry, GAMES)));
  if (running) {
    box.append(button("Stop", `Stop ${entry.name}`, () => sure(`Stop ${entry.name}?`, "What was done so far is kept; the participant is told that it is over.", () => act("stop", entry))));
  }
  if (entry.state !== "free" && entry.state !== "removed") {
    box.append(button("Remove", `Remove the data of ${entry.name}`, () => sure(`Remove all data of ${entry.name}?`, "This cannot be undone. Reports and experiments made of them are removed, too.", () => act("remove", entry))));
  }
  return box;
}

function place(entry) {
  const row = document.createElement("tr");
  const name = cell("", "th"), link = document.createElement("a");
  link.textContent = entry.name;
  link.href = entry.link;
  name.append(link);
  const problems = cell(entry.problems.join("; "));
  problems.className = "problem";
  const step = entry.step ? `${entry.position} of ${entry.steps}: ${entry.step}` : "";
  const games = entry.games === null || entry.games === undefined ? "" : `${entry.games} of ${entry.wanted}`;
  row.append(name, cell(entry.conditions.join(", ")), cell(entry.state), cell(step), cell(games), cell(seconds(entry.mean_s)), problems, buttons(entry));
  return row;
}

let last = "";

async function update() {
  let status;
  try { status = await (await fetch("status", { cache: "no-store" })).json(); } catch {
    $("summary").textContent = "The server does not answer.";
    return;
  }
  const text = JSON.stringify(status);
  if (text === last) return; // so that nobody's focus is lost for nothing
  last = text;
  const count = (state) => status.places.filter((entry) => entry.state === state).length;
  const troubled = status.places.filter((entry) => entry.problems.length).length;
  $("summary").textContent = `${status.places.length} places: ${count("here")} here, ${count("away")} away, ${count("finished")} finished, ${count("stopped")} stopped, ${count("free")} free; ${troubled} with problems.`;
  $("open-link").href = status.open_link;
  $("means").tBodies[0].replaceChildren(...status.means.map((mean) => {
    const row = document.createElement("tr");
    row.append(cell(mean.condition, "th"), cell(mean.participants), cell(mean.games), cell(seconds(mean.mean_s)));
    return row;
  }));
  const focused = document.activeElement?.getAttribute("aria-label");
  $("places").tBodies[0].replaceChildren(...status.places.map(place));
  if (focused) document.querySelector(`[aria-label="${CSS.escape(focused)}"]`)?.focus();
}

async function forever() {
  await update();
  setTimeout(forever, EVERY_MS);
}

forever();
