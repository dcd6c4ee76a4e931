// Where everybody is, in words.

const WAYS = ["right", "down_right", "down", "down_left", "left", "up_left", "up", "up_right"];

function from(a, b) {
  const dx = b.x - a.x, dy = b.y - a.y;
  return { metres: Math.round(Math.hypot(dx, dy)), way: WAYS[(Math.round(Math.atan2(dy, dx) / (Math.PI / 4)) + 8) % 8] };
}

export function tellWhere(frame, texts) {
  const players = new Map(frame.players.map((p) => [p.id, p]));
  const mine = frame.holder?.[0] === "l";
  const told = [texts.say(mine ? "you_have" : frame.holder ? "they_have" : "passed")];
  const me = players.get(frame.keepers?.[0]);
  if (!me) return told[0];
  for (const { action, mate } of frame.choices) {
    const { metres, way } = from(me, players.get(mate));
    told.push(texts.say("mate_at", { number: action, metres, direction: texts.say(way) }));
  }
  const nearest = players.get(frame.takers?.[0]);
  if (nearest) {
    const { metres, way } = from(me, nearest);
    told.push(texts.say("other_at", { metres, direction: texts.say(way) }));
  }
  return told.join(" ");
}
