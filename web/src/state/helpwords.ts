// What the help says: keys, by the part of a page where they work, and the words of the field. Pure.

import { t } from "../words/words";

export interface Keys {
  readonly keys: string;
  readonly does: string;
  /** A selector of what must be on the page; empty for every page. */
  readonly where: string;
}

export const KEYS: readonly Keys[] = [
  { keys: "Ctrl .", does: t("STOP the vessel that the page is about, at once"), where: "#stop" },
  { keys: "?", does: t("This help"), where: "" },
  { keys: "Tab", does: t("Go to the next control; Shift and Tab to the one before"), where: "" },
  { keys: "Escape", does: t("Close what is open: list of alarms, menu, question, measuring"), where: "" },
  { keys: "← → ↑ ↓", does: t("On the map: move it. On a chosen place of a plan: move that by a metre, with Shift by ten"), where: ".map" },
  { keys: "+ −", does: t("On the map or a plot: zoom"), where: ".map" },
  { keys: "Enter", does: t("While measuring: take the middle of the map as the next place. While drawing an area: as the next corner"), where: ".map" },
  { keys: "← →", does: t("On a plot: move the cursor; with Shift by more. In replay: step by a second, with Shift by ten"), where: "#vessel" },
  { keys: "Space", does: t("In replay: play and pause"), where: "#vessel" },
  { keys: t("Page↑ Page↓"), does: t("On a plot: move in time"), where: "#vessel" },
  { keys: "Ctrl Z", does: t("Undo; Ctrl and Y redo"), where: "#plan" },
  { keys: "Delete", does: t("Remove the chosen place from the plan"), where: "#plan" },
  { keys: "Ctrl ← → ↑ ↓", does: t("On the map: move the whole chosen maneuver by a metre, with Shift by ten"), where: "#plan" },
  { keys: "D", does: t("On the map or in the list of maneuvers: duplicate the chosen maneuver"), where: "#plan" },
  { keys: "R", does: t("On the map or in the list of maneuvers: reverse the way of the chosen maneuver; with Shift, reverse the whole plan"), where: "#plan" },
];

export const GLOSSARY: readonly (readonly [string, string])[] = [
  [t("Alarm, warning, caution"), t("How urgent a problem is. An emergency or an alarm needs action at once, a warning soon; a caution is for information.")],
  [t("Battery"), t("Charge as the vessel reports it, in per cent. Below 20 % it is marked.")],
  [t("Chart datum"), t("The level below which depths of the sea chart are counted. In Norway about the lowest tide, so there is usually more water, and at times less.")],
  [t("Course over ground (COG)"), t("The direction in which the vessel moves over the bottom, true. It differs from the heading in current and wind.")],
  [t("Detection"), t("One transmission of an acoustic tag that a receiver heard: time by the receiver's own clock, tag, signal-to-noise ratio, and where the vessel was then.")],
  [t("Dries"), t("Bottom that is above chart datum: it falls dry at low tide. A negative depth.")],
  [t("Executing plan"), t("The vessel sails a plan. \"2 of 4\" is the maneuver that it sails and how many the plan has.")],
  [t("Heading"), t("The direction in which the bow points, true north, three digits and T.")],
  [t("In control"), t("One person at a time commands a vessel. Others see who, and may request control. STOP needs no control.")],
  [t("Least depth on track"), t("The least depth of the chart under the way that the vessel takes, its margins included.")],
  [t("Lines in polygon"), t("A tool of the plan editor: a polygon that you draw becomes a path of parallel lines inside it. No place inside is farther from a line than half the spacing.")],
  [t("Link"), t("How the vessel reaches the server. Live: heard just now. Late: more than usual since. Stale: what is shown is old. Lost: nothing comes any more; the circle is where it can be by now.")],
  [t("Log book"), t("What a vessel logs by itself, and what people note: the pen marks their notes. A note is corrected or withdrawn, never lost.")],
  [t("Mission"), t("A time with its vessels, people and purpose, as somebody wrote it down. Its page has replay, summary, files and notes of that time.")],
  [t("Not reported"), t("The vessel has not reported it. It does not mean zero, nor that all is well.")],
  [t("Old value"), t("Struck and hatched: not heard for three of its usual intervals.")],
  [t("Overscale"), t("The map is shown larger than the chart was made for. Details are less certain than they look.")],
  [t("Parts"), t("The devices and programs aboard, each with a state: normal, fault, error.")],
  [t("Plan, maneuver"), t("A plan is a list of maneuvers: go to a place, follow a path, keep station, loiter, sail rows.")],
  [t("Ready"), t("The vessel is idle and takes plans.")],
  [t("Reverse"), t("Sail a maneuver, or the whole plan, from its end to its beginning along the same lines. A single place has no way back, and rows with diagonal turns cannot be reversed exactly.")],
  [t("Rows in rectangle"), t("A tool of the plan editor: a rectangle that you draw becomes a maneuver Rows. It starts at the first corner and runs along the longer side. Turns go beyond the rectangle by the overrun.")],
  [t("Safety depth"), t("Water deeper than this is safe for the vessel by itself. Shades on the chart go by it.")],
  [t("Shelve"), t("Hide an alarm for a set time, with a reason. It returns by itself.")],
  [t("Safe, not safe"), t("What the sea chart says of a plan from its first place on. The way from the vessel to that place is judged when the plan is brought aboard and started.")],
  [t("Signal-to-noise ratio (SNR)"), t("How far a tag's signal is above the noise, dB. Higher is better; it says little of the distance.")],
  [t("Speed over ground (SOG)"), t("How fast the vessel moves over the bottom, in knots (1 kn is 0.514 m/s).")],
  [t("STOP"), t("Cancels the current plan or order and stops the motors. The vessel then drifts. STOP ALL does it for every vessel, after a second press.")],
  [t("Tag"), t("An acoustic transmitter on a fish, named by protocol and number, like R64K-1234.")],
  [t("UTC"), t("All times here. Norway is one hour ahead in winter and two in summer.")],
];
