// The end of a demonstration: thanks, where it is, and what to do with it.

const $ = (id) => document.getElementById(id);

export function sayFarewell({ kept, episodes, file, next }, played) {
  const complete = file && (!episodes || kept >= episodes);
  $("farewell-title").textContent = played && complete ? "Thank you!" : "The demonstration is over";
  const many = kept === 1 ? "1 episode is" : `${kept} episodes are`;
  const later = complete ? "" : " To go on with the same file later, give the same command with --resume.";
  $("farewell-text").textContent = file ? `${many} recorded in ${file}.${later}` : "Nothing was recorded.";
  $("farewell-next").hidden = !next;
  $("farewell-command").textContent = next ?? "";
}
