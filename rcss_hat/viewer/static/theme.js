// Colours: as the system, light, or dark; remembered where the browser allows it.

const NAMES = { auto: "Theme: auto", light: "Theme: light", dark: "Theme: dark" };
const system = matchMedia("(prefers-color-scheme: dark)");

function stored() {
  try { return localStorage.getItem("rcss-hat-theme"); } catch { return null; }
}

export class Theme {
  // name: what the button says of a choice.
  constructor(button, changed, name = (choice) => NAMES[choice]) {
    this.name = name;
    this.button = button;
    this.changed = changed;
    this.choice = stored() in NAMES ? stored() : "auto";
    system.addEventListener("change", () => this.apply());
    button.addEventListener("click", () => this.next());
    this.apply();
  }

  next() {
    const names = Object.keys(NAMES);
    this.choice = names[(names.indexOf(this.choice) + 1) % names.length];
    try { localStorage.setItem("rcss-hat-theme", this.choice); } catch { /* nothing is remembered */ }
    this.apply();
  }

  apply() {
    const dark = this.choice === "dark" || (this.choice === "auto" && system.matches);
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    this.button.textContent = this.name(this.choice);
    this.changed();
  }
}
