// The page's texts: one file per language (text.en.json and so on); nothing that people read stands elsewhere.

const available = document.querySelector("meta[name=languages]").content.split(" ");
const KEY = "rcss-hat-language";

function remembered() {
  try { return localStorage.getItem(KEY); } catch { return null; }
}

// The language to show: the one that is prescribed or chosen, else the first of the browser's that there is.
function choose(prescribed) {
  const wanted = [prescribed, remembered(), ...navigator.languages].filter(Boolean).map((name) => name.toLowerCase().split("-")[0]);
  return wanted.find((name) => available.includes(name)) ?? available[0];
}

export class Texts {
  constructor() { this.words = {}; this.language = null; this.available = available; }

  async load(prescribed) {
    const language = choose(prescribed);
    if (language === this.language) return;
    const response = await fetch(`text.${language}.json`);
    this.words = await response.json();
    this.language = language;
    this.plural = new Intl.PluralRules(language);
    document.documentElement.lang = language;
    this.fill();
  }

  async change(language) {
    try { localStorage.setItem(KEY, language); } catch { /* nothing is remembered */ }
    await this.load(language);
  }

  has(key) { return key in this.words; }

  // The text of a key; {names} in it are replaced by values; of several forms the one for the number n is taken.
  say(key, values = {}) {
    const found = this.words[key] ?? key;
    const text = typeof found === "string" ? found : found[this.plural.select(values.n)] ?? found.other;
    return text.replace(/\{(\w+)\}/g, (whole, name) => (name in values ? String(values[name]) : whole));
  }

  // "1 or 2", "1, 2 or 3"
  list(items) {
    const last = items[items.length - 1];
    return items.length > 1 ? this.say("or", { first: items.slice(0, -1).join(", "), second: last }) : String(last);
  }

  number(value, digits = 1) {
    return value.toLocaleString(this.language, { minimumFractionDigits: digits, maximumFractionDigits: digits });
  }

  fill() {
    for (const node of document.querySelectorAll("[data-text]")) node.textContent = this.say(node.dataset.text);
    for (const node of document.querySelectorAll("[data-label]")) node.setAttribute("aria-label", this.say(node.dataset.label));
    for (const node of document.querySelectorAll("[data-title]")) node.title = this.say(node.dataset.title);
    document.title = this.say("title");
  }
}
