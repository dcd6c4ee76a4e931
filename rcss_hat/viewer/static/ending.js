// The end of a demonstration: thanks, where it is, and what to do with it.

const $ = (id) => document.getElementById(id);

export function sayFarewell({ kept, episodes, file, next }, played, texts) {
  const complete = file && (!episodes || kept >= episodes);
  $("farewell-title").textContent = texts.say(played && complete ? "thanks" : "ended");
  const where = file ? texts.say("kept_in", { n: kept, file }) : texts.say("kept_none");
  $("farewell-text").textContent = complete || !file ? where : `${where} ${texts.say("later")}`;
  $("farewell-next").hidden = !next;
  $("farewell-command").textContent = next ?? "";
}
