// What the help says: keys, by the part of a page where they work, and the words of the field. Pure.

export interface Keys {
  readonly keys: string;
  readonly does: string;
  /** A selector of what must be on the page; empty for every page. */
  readonly where: string;
}

export const KEYS: readonly Keys[] = [
  { keys: "Ctrl .", does: "STOP the vessel that the page is about, at once", where: "#stop" },
  { keys: "?", does: "This help", where: "" },
  { keys: "Tab", does: "Go to the next control; Shift and Tab to the one before", where: "" },
  { keys: "Escape", does: "Close what is open: list of alarms, menu, question, measuring", where: "" },
  { keys: "← → ↑ ↓", does: "On the map: move it. On a chosen place of a plan: move that by a metre, with Shift by ten", where: ".map" },
  { keys: "+ −", does: "On the map or a plot: zoom", where: ".map" },
  { keys: "Enter", does: "While measuring: take the middle of the map as the next place. While drawing an area: as the next corner", where: ".map" },
  { keys: "← →", does: "On a plot: move the cursor; with Shift by more. In replay: step by a second, with Shift by ten", where: "#vessel" },
  { keys: "Space", does: "In replay: play and pause", where: "#vessel" },
  { keys: "Page↑ Page↓", does: "On a plot: move in time", where: "#vessel" },
  { keys: "Ctrl Z", does: "Undo; Ctrl and Y redo", where: "#plan" },
  { keys: "Delete", does: "Take the chosen place out of the plan", where: "#plan" },
  { keys: "Ctrl ← → ↑ ↓", does: "On the map: move the whole chosen maneuver by a metre, with Shift by ten", where: "#plan" },
  { keys: "D", does: "On the map or in the list of maneuvers: duplicate the chosen maneuver", where: "#plan" },
  { keys: "R", does: "On the map or in the list of maneuvers: reverse the way of the chosen maneuver; with Shift, reverse the whole plan", where: "#plan" },
];

export const GLOSSARY: readonly (readonly [string, string])[] = [
  ["Alarm, warning, caution", "How urgent a trouble is. Emergency and alarm want somebody at once, a warning soon, a caution needs nobody."],
  ["Battery", "Charge as the vessel reports it, in per cent. Below 20 % it is marked."],
  ["Chart datum", "The level below which depths of the sea chart are counted. In Norway about the lowest tide, so there is usually more water, and at times less."],
  ["Course over ground (COG)", "The direction in which the vessel moves over the bottom, true. It differs from the heading in current and wind."],
  ["Detection", "One transmission of an acoustic tag that a receiver heard: time by the receiver's own clock, tag, signal-to-noise ratio, and where the vessel was then."],
  ["Dries", "Bottom that is above chart datum: it falls dry at low tide. A negative depth."],
  ["Executing plan", "The vessel sails a plan. \"2 of 4\" is the maneuver that it sails and how many the plan has."],
  ["Heading", "The direction in which the bow points, true north, three digits and T."],
  ["In control", "One person at a time commands a vessel. Others see who, and may request control. STOP needs no control."],
  ["Least depth on track", "The least depth of the chart under the way that the vessel takes, its margins included."],
  ["Lines in polygon", "A tool of the plan editor: a polygon that you draw becomes a path of parallel lines inside it. No place inside is farther from a line than half the spacing."],
  ["Link", "How the vessel reaches the server. Live: heard just now. Late: more than usual since. Stale: what is shown is old. Lost: nothing comes any more; the circle is where it can be by now."],
  ["Log book", "What a vessel logs by itself, and what people note: the pen marks their notes. A note is corrected or withdrawn, never lost."],
  ["Mission", "A time with its vessels, people and purpose, as somebody wrote it down. Its page has replay, summary, files and notes of that time."],
  ["Not reported", "The vessel has not said it. It does not mean zero, and not that all is well."],
  ["Old value", "Struck and hatched: not heard for three of its usual intervals."],
  ["Overscale", "The map is shown larger than the chart was made for. Details are less certain than they look."],
  ["Parts", "The devices and programs aboard, each with a state: normal, fault, error."],
  ["Plan, maneuver", "A plan is a list of maneuvers: go to a place, follow a path, keep station, loiter, sail rows."],
  ["Ready", "The vessel is idle and takes plans."],
  ["Reverse", "Sail a maneuver, or the whole plan, from its end to its beginning along the same lines. A single place has no way back, and rows with diagonal turns have not exactly one."],
  ["Rows in rectangle", "A tool of the plan editor: a rectangle that you draw becomes a maneuver Rows. It starts at the first corner and runs along the longer side. Turns go beyond the rectangle by the overrun."],
  ["Safety depth", "Water deeper than this is safe for the vessel by itself. Shades on the chart go by it."],
  ["Shelve", "Put an alarm aside for a while, with a reason. It comes back by itself."],
  ["Safe, not safe", "What the sea chart says of a plan from its first place on. The way from the vessel to that place is judged when the plan is brought aboard and started."],
  ["Signal-to-noise ratio (SNR)", "How far a tag's signal is above the noise, dB. Higher is better; it says little of the distance."],
  ["Speed over ground (SOG)", "How fast the vessel moves over the bottom, in knots (1 kn is 0.514 m/s)."],
  ["STOP", "Ends what the vessel does and stops its motors. It then drifts. STOP ALL does it for every vessel, after a second press."],
  ["Tag", "An acoustic transmitter on a fish, named by protocol and number, like R64K-1234."],
  ["UTC", "All times here. Norway is one hour ahead in winter and two in summer."],
];
