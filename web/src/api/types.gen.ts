// Made from crates/api by `make types`. Do not edit.

export type Alarm = { 
/**
 * Its number; grows, and is never used again.
 */
id: number, 
/**
 * IMC address of the vessel; null for the server itself.
 */
vessel: number | null, 
/**
 * What the vessel calls itself, or its address; null for the server itself.
 */
vessel_name: string | null, 
/**
 * What, for machines: `not_heard`, `position`, `battery`, …
 */
kind: string, 
/**
 * Which part of the vessel; empty where there is only one.
 */
part: string, 
/**
 * `unacknowledged`, `acknowledged`, `returned`, or `normal` for one that is over.
 */
state: string, 
/**
 * `emergency`, `alarm`, `warning` or `caution`.
 */
priority: string, 
/**
 * What, by codes with figures, from which pages make words in a person's language; empty where it was kept by an older
 * server.
 */
says: Array<AlarmSaying>, 
/**
 * The same in words: in English, for scripts and logs; in a webhook in the language of the person who asked for it.
 */
text: string, 
/**
 * Why such an alarm comes.
 */
cause: string, 
/**
 * What follows if no one acts on it.
 */
consequence: string, 
/**
 * What to do.
 */
action: string, 
/**
 * Since when it is wrong, or was, µs since 1970 UTC.
 */
since_us: number, 
/**
 * Since when it is not wrong any more, µs since 1970 UTC; null while it is.
 */
over_us: number | null, 
/**
 * How often it came since it was normal.
 */
count: number, 
/**
 * Who acknowledged it; null while no one has.
 */
acknowledged: AlarmWord | null, 
/**
 * Whether it became more urgent because it was not acknowledged.
 */
escalated: boolean, 
/**
 * Whether it comes and goes so fast that it is held.
 */
chatters: boolean, 
/**
 * Shelved for a time; null if not.
 */
shelved: AlarmShelving | null, 
/**
 * The alarm that it is part of at present, so that it is not reported itself; null for none.
 */
collapsed: string | null, 
/**
 * How often it sounded: a client sounds when this grows.
 */
sounded: number, 
/**
 * Whether a person has to acknowledge it.
 */
wants_acknowledgement: boolean, };

export type At = { 
/**
 * The time asked for, µs since 1970 UTC.
 */
time_us: number, 
/**
 * The last sample of every series at or before it, of 31 days at most; its age is `time_us` less its own. The
 * history does not distinguish instances within an entity.
 */
values: Array<Update>, 
/**
 * Whether there were more series than fit.
 */
cut: boolean, };

export type AlarmHistory = { 
/**
 * The newest first.
 */
notes: Array<AlarmNote>, 
/**
 * The `before` of a query for older entries; null if these are the oldest.
 */
next: number | null, };

export type AlarmList = { 
/**
 * Alarms that are not normal, and shelved ones; the most urgent first.
 */
standing: Array<Alarm>, 
/**
 * The latest changes since the server started, the newest first.
 */
history: Array<AlarmNote>, };

export type AlarmNote = { 
/**
 * When, µs since 1970 UTC.
 */
time_us: number, 
/**
 * The alarm's number.
 */
id: number, 
/**
 * IMC address of the vessel; null for the server itself.
 */
vessel: number | null, 
/**
 * The vessel's name then; null for the server itself.
 */
vessel_name: string | null, 
/**
 * What, for machines.
 */
kind: string, 
/**
 * How urgent it was then.
 */
priority: string, 
/**
 * `raised`, `again`, `more urgent`, `escalated`, `acknowledged`, `returned`, `over`, `shelved` or
 * `off the shelf`.
 */
what: string, 
/**
 * The person who did it; empty where no person did.
 */
by: string, 
/**
 * The alarm's words by codes with figures; empty where the words are a person's.
 */
says: Array<AlarmSaying>, 
/**
 * The alarm's words, or the person's.
 */
text: string, };

export type AlarmSaying = { "code": "part", 
/**
 * Its label.
 */
part: string, 
/**
 * `fault`, `error` or `failure`.
 */
state: string, 
/**
 * Its own words; may be empty.
 */
words: string, } | { "code": "no_position", 
/**
 * µs since 1970 UTC.
 */
since_us: number, } | { "code": "hydrophone_silent", 
/**
 * µs since 1970 UTC.
 */
since_us: number, } | { "code": "not_heard", 
/**
 * µs since 1970 UTC.
 */
since_us: number, } | { "code": "never_heard", 
/**
 * When it started, µs since 1970 UTC.
 */
since_us: number, } | { "code": "other_source", 
/**
 * Their address.
 */
peer: string, 
/**
 * By which transport.
 */
transport: string, } | { "code": "charge", 
/**
 * Percent.
 */
percent: number, } | { "code": "clock", 
/**
 * The vessel's minus the server's (ms).
 */
ahead_ms: number, } | { "code": "chart", 
/**
 * Whether it has any.
 */
held: boolean, 
/**
 * How they differ, and the state of the transfer.
 */
difference: ChartDifference, } | { "code": "log_book", 
/**
 * Which part did.
 */
part: string, 
/**
 * What is said.
 */
words: string, } | { "code": "server", 
/**
 * Why, in the words of its system.
 */
words: string, } | { "code": "disk", 
/**
 * What is free (MiB).
 */
free_mib: number, } | { "code": "certificate_ends", 
/**
 * Its file.
 */
file: string, 
/**
 * When, µs since 1970 UTC.
 */
until_us: number, } | { "code": "certificate_ended", 
/**
 * Its file.
 */
file: string, 
/**
 * When, µs since 1970 UTC.
 */
until_us: number, } | { "code": "certificate_refused", 
/**
 * Which file, why, and what to do, in the server's words.
 */
words: string, } | { "code": "no_go_areas", 
/**
 * Why, in the server's words.
 */
words: string, } | { "code": "too_many", 
/**
 * Those without a place.
 */
count: number, 
/**
 * How many are kept.
 */
most: number, };

export type ChartDifference = { "stage": "other" } | { "stage": "fetching", 
/**
 * How much of it is aboard (%).
 */
percent: number, } | { "stage": "waiting", 
/**
 * Why, in the vessel's words.
 */
why: string, } | { "stage": "failed", 
/**
 * Why, in the vessel's words.
 */
why: string, } | { "stage": "declined" } | { "stage": "none_ashore" };

export type AlarmShelving = { 
/**
 * By whom.
 */
by: string, 
/**
 * When, µs since 1970 UTC.
 */
time_us: number, 
/**
 * Until when, µs since 1970 UTC.
 */
until_us: number, 
/**
 * The reason that the person gave.
 */
reason: string, };

export type AlarmWord = { 
/**
 * The person.
 */
by: string, 
/**
 * When, µs since 1970 UTC.
 */
time_us: number, };

export type AuditEntry = { 
/**
 * Number, growing.
 */
id: number, 
/**
 * When, µs since 1970 UTC.
 */
time_us: number, 
/**
 * The person or program that did it.
 */
actor: string, 
/**
 * From which address; `command line` for the program itself.
 */
address: string, 
/**
 * What, like `user.add`.
 */
action: string, 
/**
 * To whom or what.
 */
subject: string, 
/**
 * `done`, or why not.
 */
outcome: string, };

export type Buckets = { 
/**
 * Unit of the values; empty for none.
 */
unit: string, 
/**
 * How long each bucket is, µs. Where it is shorter than the samples are apart, each holds one.
 */
width_us: number, 
/**
 * Where each begins, µs since 1970 UTC.
 */
start_us: number[], 
/**
 * Time of the first sample of each, µs since 1970 UTC.
 */
first_us: number[], 
/**
 * How many samples; those that are not a number count for nothing.
 */
count: number[], 
/**
 * The least.
 */
min: Array<number>, 
/**
 * The greatest.
 */
max: Array<number>, 
/**
 * The mean; null where the sum is beyond what a double holds.
 */
mean: Array<number | null>, 
/**
 * The first.
 */
first: Array<number>, 
/**
 * The last.
 */
last: Array<number>, };

export type ChartAttribute = { 
/**
 * Its acronym in S-57.
 */
name: string, 
/**
 * What it is, in words.
 */
words: string, 
/**
 * Its value as charted.
 */
value: string, 
/**
 * Its value in words, with its unit.
 */
text: string, };

export type ChartBounds = { 
/**
 * Least latitude (°).
 */
south_deg: number, 
/**
 * Least longitude (°).
 */
west_deg: number, 
/**
 * Greatest latitude (°).
 */
north_deg: number, 
/**
 * Greatest longitude (°).
 */
east_deg: number, };

export type ChartCell = { 
/**
 * Name of the cell, or of the file without its ending.
 */
name: string, 
/**
 * Edition.
 */
edition: string, 
/**
 * Number of the last update.
 */
update: string, 
/**
 * Compilation scale, 1 : this; 0 if unknown.
 */
scale: number, 
/**
 * Usage band, 1 overview to 6 berthing; 0 for what is not a cell.
 */
band: number, 
/**
 * Date of issue (YYYYMMDD).
 */
issued: string, 
/**
 * Its producer's comment.
 */
comment: string, 
/**
 * Whether its depths and land tile what it covers, without gap or overlap; null for what is not a cell.
 */
whole: boolean | null, };

export type ChartCorridor = { 
/**
 * Length of all of it (m).
 */
length_m: number, 
/**
 * From point to point.
 */
pieces: Array<ChartPiece>, 
/**
 * The charted depth right below the way, at its points and evenly between them.
 */
profile: Array<ChartProfilePoint>, };

export type ChartCorridorRequest = { 
/**
 * Latitude and longitude of its points (°), 2 to 500.
 */
points: Array<[number, number]>, 
/**
 * Half the width of the corridor (m), 0 to 1000.
 */
half_width_m: number, };

export type ChartDepth = { 
/**
 * `land`, `obstacle`, `unknown-depth`, `no-data`, `too-low`, `intertidal` or `water`.
 */
kind: string, 
/**
 * Least charted depth (m); null where it is not water of known depth.
 */
least_m: number | null, 
/**
 * Greatest charted depth of the area (m), where given.
 */
greatest_m: number | null, 
/**
 * Margin to the least depth for autonomous sailing (m): negative = too shallow.
 */
margin_m: number | null, 
/**
 * Whether a vessel may sail there autonomously.
 */
autonomous: boolean, 
/**
 * Whether it may be driven there.
 */
navigable: boolean, 
/**
 * Where that is: latitude (°).
 */
lat_deg: number, 
/**
 * Where that is: longitude (°).
 */
lon_deg: number, 
/**
 * The object that decides, numbered as in tiles; null where nothing is charted.
 */
object: number | null, 
/**
 * Its class, an acronym of S-57.
 */
class: string | null, 
/**
 * Its class in words.
 */
words: string | null, 
/**
 * Its name, where it has one.
 */
name: string | null, 
/**
 * The chart it is from.
 */
cell: string | null, 
/**
 * Edition of that chart.
 */
edition: string | null, 
/**
 * Last update of that chart.
 */
update: string | null, 
/**
 * Compilation scale of that chart, 1 : this.
 */
scale: number | null, 
/**
 * Zone of confidence (CATZOC): 1 = A1, 2 = A2, 3 = B, 4 = C, 5 = D, 6 = unassessed.
 */
zone: number | null, };

export type ChartNear = { 
/**
 * How deep it is.
 */
depth: ChartDepth, 
/**
 * Objects nearby, the nearest first, then the areas that hold the place, the smallest first; up to 50 in all.
 */
objects: Array<ChartObject>, };

export type ChartObject = { 
/**
 * Its number, as in tiles.
 */
id: number, 
/**
 * Its class, an acronym of S-57.
 */
class: string, 
/**
 * Its class in words.
 */
words: string, 
/**
 * Its name, where it has one.
 */
name: string | null, 
/**
 * `point`, `line`, `area` or `sounding`.
 */
geometry: string, 
/**
 * How far it is (m); 0 within an area.
 */
distance_m: number, 
/**
 * Depth of a sounding (m).
 */
depth_m: number | null, 
/**
 * What the chart says of it.
 */
attributes: Array<ChartAttribute>, 
/**
 * The chart it is from.
 */
cell: string, 
/**
 * Edition of that chart.
 */
edition: string, 
/**
 * Last update of that chart.
 */
update: string, 
/**
 * Compilation scale of that chart, 1 : this; 0 if unknown.
 */
scale: number, };

export type ChartPiece = { 
/**
 * Where it begins along the way (m).
 */
from_m: number, 
/**
 * Its length (m).
 */
length_m: number, 
/**
 * How far along the way its worst spot is (m).
 */
along_m: number, 
/**
 * The worst spot within the width.
 */
worst: ChartDepth, };

export type ChartProfilePoint = { 
/**
 * How far along the way (m).
 */
along_m: number, 
/**
 * Least charted depth (m); null where it is not water of known depth.
 */
depth_m: number | null, 
/**
 * What is there, as in ChartDepth.
 */
kind: string, };

export type ChartSet = { 
/**
 * Names its contents, for the address of tiles; null where there is no chart, which
 * `lutra-server chart import` changes.
 */
set: string | null, 
/**
 * Why the chart file cannot be used; null where all is well.
 */
trouble: string | null, 
/**
 * The charts in it by name.
 */
cells: Array<ChartCell>, 
/**
 * The box that they cover; null where that is empty.
 */
bounds: ChartBounds | null, 
/**
 * Whether a chart in it says of itself that it is not for navigation.
 */
not_for_navigation: boolean, 
/**
 * Least depth in which an operator may steer a vessel by hand (m).
 */
navigable_m: number, 
/**
 * Least depth in which it may sail autonomously (m).
 */
autonomous_m: number, };

export type Command = { 
/**
 * Its number; grows.
 */
id: number, 
/**
 * IMC address of the vessel.
 */
vessel: number, 
/**
 * Who ordered it.
 */
by: string, 
/**
 * Like `plan.start`.
 */
order: string, 
/**
 * Its subject, in words; may be empty.
 */
subject: string, 
/**
 * The stages reached, in order.
 */
steps: Array<CommandStep>, 
/**
 * Whether nothing more is expected.
 */
over: boolean, 
/**
 * The plan that was asked for; only where a single command is asked for.
 */
plan: PlanGiven | null, 
/**
 * The parameters that the vessel reported; only where a single command is asked for.
 */
parameters: Array<Parameter> | null, };

export type CommandStep = { 
/**
 * `accepted`, `sent`, `received`, `executing`, `effect seen`, or the end of another kind: `refused`, `expired`,
 * `timed out`.
 */
stage: string, 
/**
 * When, µs since 1970 UTC.
 */
time_us: number, 
/**
 * The vessel's words, or why; may be empty.
 */
text: string, 
/**
 * Of what pages make `text` in their reader's language; absent of a vessel's own words.
 */
says?: Wording, 
/**
 * Whether it was reached after the command had timed out; `text` begins with `late` then.
 */
late: boolean, 
/**
 * The leg for which the vessel's guard refused it, where it named one; null else.
 */
leg: GuardReason | null, };

export type Dataset = { 
/**
 * Its number; never used again.
 */
id: number, 
/**
 * Grows with each change, from 1.
 */
revision: number, 
/**
 * How far it is.
 */
state: DatasetState, 
/**
 * Who made it, and when.
 */
made: LogWord, 
/**
 * The unpublished draft; null if the dataset has no draft.
 */
draft: DatasetDraft | null, 
/**
 * Published versions, the newest first.
 */
versions: Array<DatasetVersion>, 
/**
 * Why it was withdrawn; null where it was not.
 */
withdrawn: DatasetWithdrawn | null, 
/**
 * Whether the requester may change, publish, share and download it.
 */
may_change: boolean, };

export type DatasetAuthor = { 
/**
 * The name.
 */
name: string, 
/**
 * ORCID; empty where they have none.
 */
orcid: string, 
/**
 * Where they work; empty where the register does not say.
 */
affiliation: string, };

export type DatasetChange = { 
/**
 * The revision that is changed; 409 when there is a newer one.
 */
revision: number, 
/**
 * Its new content.
 */
draft: DatasetDraft, };

export type DatasetCheck = { 
/**
 * When that was computed.
 */
checked_us: number, 
/**
 * Whether the bytes are those that were published.
 */
is_same: boolean, 
/**
 * Detections at publication.
 */
rows: number, 
/**
 * Detections now.
 */
rows_now: number, 
/**
 * SHA-256 of the canonical CSV now.
 */
sha256_now: string, 
/**
 * What wrote the bytes that were published, where its canonical format is another one than now: other bytes say nothing of the
 * archive then.
 */
written_by: string | null, 
/**
 * In words.
 */
text: string, };

export type DatasetContent = { 
/**
 * Detections.
 */
rows: number, 
/**
 * Bytes of the canonical CSV.
 */
bytes: number, 
/**
 * SHA-256 of it, in hexadecimal digits.
 */
sha256: string, 
/**
 * Their extent.
 */
covered: DatasetCovered, 
/**
 * The number of the canonical format: bytes of another number are not compared. 0 where it was not kept.
 */
format: number, 
/**
 * The program that wrote it, like `Lutra 0.1.0`.
 */
software: string, };

export type DatasetCovered = { 
/**
 * When the first was heard; null without detections.
 */
first_us: number | null, 
/**
 * When the last was.
 */
last_us: number | null, 
/**
 * WGS-84 latitude of the southernmost place, degrees; null where no place is known.
 */
south_deg: number | null, 
/**
 * Of the northernmost.
 */
north_deg: number | null, 
/**
 * WGS-84 longitude of the westernmost place, degrees.
 */
west_deg: number | null, 
/**
 * Of the easternmost.
 */
east_deg: number | null, };

export type DatasetDraft = { 
/**
 * Its title.
 */
title: string, 
/**
 * What it is, how it was made, what to know before it is used.
 */
description: string, 
/**
 * Who publishes it: the institution. Citation and DataCite need it.
 */
publisher: string, 
/**
 * Names of people of the register, in the order in which they are cited.
 */
authors: Array<string>, 
/**
 * `CC-BY-4.0` (also where left empty), `CC0-1.0`, `CC-BY-NC-4.0`, or own words.
 */
licence: string, 
/**
 * Day from which others get the data, such as `2027-01-31`, from its beginning in UTC; at once when empty.
 */
embargo_until: string, 
/**
 * DOI that a registry has given, such as `10.5281/zenodo.1234`; empty where it has none.
 */
doi: string, 
/**
 * Which detections.
 */
query: DatasetQuery, };

export type DatasetQuery = { 
/**
 * Reported from this time on.
 */
from_us: number | null, 
/**
 * Reported before this time; where it is null or later than the publication, that is the end.
 */
to_us: number | null, 
/**
 * Vessels by IMC address; empty for all: that needs the role on all vessels.
 */
vessels: Array<number>, 
/**
 * Tags as protocol and number (`S256-101`) or as number alone (`101`).
 */
tags: Array<string>, 
/**
 * Projects of the register by name: of the tag, or of the animal that carried it.
 */
projects: Array<string>, 
/**
 * Corners of an area, 3 to 100, as `lat,lon;lat,lon;…` in degrees.
 */
area: string, 
/**
 * Detections with one of these flags are left out.
 */
without: Array<FlagCode>, };

export type DatasetShare = { 
/**
 * Its number.
 */
id: number, 
/**
 * The version that it gives.
 */
version: number, 
/**
 * For whom it is.
 */
label: string, 
/**
 * Whether it asks for a password.
 */
has_password: boolean, 
/**
 * The one account that can open it. Null: anyone with the address.
 */
person: string | null, 
/**
 * When it ends.
 */
expires_us: number, 
/**
 * Only what was reported from this time on.
 */
from_us: number | null, 
/**
 * Only what was reported before this time.
 */
to_us: number | null, 
/**
 * Only these tags.
 */
tags: Array<string>, 
/**
 * Only within this area.
 */
area: string, 
/**
 * About how long the side of a cell is; null where places are given as they are.
 */
precision_m: number | null, 
/**
 * What it gives.
 */
content: DatasetContent, 
/**
 * Whether the archive gave other bytes than were published when the link was made.
 */
had_changed: boolean, 
/**
 * Who made it, and when.
 */
made: LogWord, 
/**
 * Who revoked it, and when; null while it holds.
 */
revoked: LogWord | null, 
/**
 * How often it was viewed.
 */
views: number, 
/**
 * How often something was downloaded.
 */
downloads: number, 
/**
 * When it was used last; null where never.
 */
used_us: number | null, };

export type DatasetShareMade = { 
/**
 * The link.
 */
share: DatasetShare, 
/**
 * Its path on this server: `/s/…`. It gives access to the data without a login, unless it is for one account.
 */
path: string, };

export type SharedDataset = { 
/**
 * The path of its page on this server; its files lie below.
 */
path: string, 
/**
 * The title of the dataset.
 */
title: string, 
/**
 * The version that is shared.
 */
version: number, 
/**
 * How to cite it.
 */
citation: string, 
/**
 * Detections that it gives.
 */
rows: number, 
/**
 * Day on which the embargo ends. Empty: no embargo.
 */
embargo_until: string, 
/**
 * Who shared it, and when.
 */
made: LogWord, 
/**
 * When the share ends.
 */
expires_us: number, };

export type DatasetShareRequest = { 
/**
 * Which version; the newest when null.
 */
version: number | null, 
/**
 * For whom it is.
 */
label: string, 
/**
 * How many days it opens, 1 to 730.
 */
days: number, 
/**
 * A password that is also required; none when empty.
 */
password: string, 
/**
 * Name of the one account that can open it. Null: anyone with the address.
 */
person: string | null, 
/**
 * Only what was reported from this time on.
 */
from_us: number | null, 
/**
 * Only what was reported before this time.
 */
to_us: number | null, 
/**
 * Only these tags.
 */
tags: Array<string>, 
/**
 * Only within this area; where places are coarsened, the coarsened place counts.
 */
area: string, 
/**
 * Places are given as the middle of a cell of about 100, 1000 or 10000 m; as they are when null.
 */
precision_m: number | null, };

export type DatasetState = "draft" | "published" | "withdrawn";

export type DatasetStep = { 
/**
 * The revision that is meant; 409 when there is a newer one.
 */
revision: number, };

export type DatasetVersion = { 
/**
 * 1, 2, …
 */
number: number, 
/**
 * Its title.
 */
title: string, 
/**
 * What it is.
 */
description: string, 
/**
 * Who publishes it.
 */
publisher: string, 
/**
 * In the order in which they are cited.
 */
authors: Array<DatasetAuthor>, 
/**
 * An SPDX identifier, or own words.
 */
licence: string, 
/**
 * Day from which others get the data; empty where at once.
 */
embargo_until: string, 
/**
 * DOI; empty where it has none.
 */
doi: string, 
/**
 * Which detections, with the vessels and the end of the time that publication gave it.
 */
query: DatasetQuery, 
/**
 * Its vessels.
 */
vessels: Array<DatasetVessel>, 
/**
 * What it had at publication.
 */
content: DatasetContent, 
/**
 * Who published it, and when.
 */
published: LogWord, 
/**
 * How to cite it.
 */
citation: string, };

export type DatasetVessel = { 
/**
 * IMC address.
 */
system: number, 
/**
 * Its name at publication; empty where it had none.
 */
name: string, };

export type DatasetWithdrawal = { 
/**
 * The revision that is meant; 409 when there is a newer one.
 */
revision: number, 
/**
 * Why, for those who cited it.
 */
reason: string, };

export type DatasetWithdrawn = { 
/**
 * Who did it, and when.
 */
written: LogWord, 
/**
 * The reason.
 */
reason: string, };

export type ShareVisit = { 
/**
 * Time of the visit.
 */
time_us: number, 
/**
 * From which network address.
 */
address: string, 
/**
 * What the visitor did.
 */
what: ShareVisitKind, 
/**
 * Which file; empty where none.
 */
file: string, };

export type ShareVisitKind = "view" | "download" | "wrong_password";

export type Detection = { 
/**
 * The entity that reported it.
 */
entity: number, 
/**
 * When its line came to the vessel and was reported, by the vessel's clock, µs since 1970 UTC.
 */
time_us: number, 
/**
 * When the receiver heard it, by the receiver's clock, to the millisecond, µs since 1970 UTC; null where that clock was
 * never set, or was lost.
 */
heard_us: number | null, 
/**
 * When the report first came ashore, µs since 1970 UTC.
 */
received_us: number, 
/**
 * Serial number of the receiver.
 */
serial_no: number, 
/**
 * Its maker in one word, such as `innovasea`, where a file of another receiver said it: makers give the same numbers. Null
 * for what vessels report.
 */
maker: string | null, 
/**
 * Number of the tag's protocol, by IMC; null where IMC has none.
 */
protocol: number | null, 
/**
 * Its name, such as `R64K`.
 */
protocol_name: string | null, 
/**
 * The tag's number.
 */
tag_id: number, 
/**
 * The tag's measurement, as it was sent; null where it sent none.
 */
data: number | null, 
/**
 * Signal to noise ratio, dB; null where the receiver, or the file it came by, does not say it.
 */
snr_db: number | null, 
/**
 * Frequency, kHz; null likewise.
 */
frequency_khz: number | null, 
/**
 * Place in the receiver's memory, which is the running number of its line.
 */
memory_address: number, 
/**
 * WGS-84 latitude of the vessel then, degrees, north positive; null where it did not know.
 */
lat_deg: number | null, 
/**
 * WGS-84 longitude of the vessel then, degrees, east positive; null where it did not know.
 */
lon_deg: number | null, 
/**
 * Names it among those of its vessel: the same live and from the history.
 */
id: string, 
/**
 * IMC address of the vessel.
 */
system: number, 
/**
 * What is known of the receiver's clock.
 */
clock: ReceiverClock, 
/**
 * What the receiver's clock counted, µs: since 1970 UTC where it is set, else since an unknown moment.
 */
clock_us: number, 
/**
 * Time between the detection and the vessel's nearest measured position, s.
 */
pose_age_s: number | null, 
/**
 * Standard deviation of the place on each axis, m.
 */
pose_sigma_m: number | null, 
/**
 * Lines of the receiver that were lost right before this one.
 */
lines_lost: number | null, 
/**
 * Mean noise that the receiver reported last, in its own counts.
 */
noise_average: number | null, 
/**
 * Peak noise, likewise.
 */
noise_peak: number | null, 
/**
 * How long before that was, s.
 */
noise_age_s: number | null, 
/**
 * Speed of the vessel's faster propeller, rpm, without direction.
 */
propeller_rpm: number | null, 
/**
 * The receiver's line as it came, without its end.
 */
raw: string | null, 
/**
 * Time to the nearest other detection of the tag by the same receiver, s; null where none is within a day, and where
 * it was not computed.
 */
min_lag_s: number | null, 
/**
 * Why it is doubtful; null where that was not computed, as in live detections.
 */
flags: Array<DetectionFlag> | null, };

export type DetectionFlag = { 
/**
 * What it is.
 */
code: FlagCode, 
/**
 * Why, with the figures.
 */
reason: string, 
/**
 * The figure of the reason, in the unit that the code has: s, or lines; null where it has none.
 */
figure: number | null, };

export type DetectionsSummary = { 
/**
 * How many there are.
 */
detections: number, 
/**
 * Begin of the plots, µs since 1970 UTC; null without detections.
 */
from_us: number | null, 
/**
 * Their end.
 */
to_us: number | null, 
/**
 * How long a step of `tags[].marks` is, µs; the first begins at `from_us`.
 */
step_us: number, 
/**
 * Tags, the one that was heard most first; at most 100.
 */
tags: Array<SummaryTag>, 
/**
 * How many tags there are, listed or not.
 */
tags_all: number, 
/**
 * How long a bar is, µs; an hour or more.
 */
bar_us: number, 
/**
 * Detections and effort by time, in order; empty bars are left out.
 */
bars: Array<SummaryBar>, 
/**
 * Where, in squares; empty ones are left out.
 */
squares: Array<SummarySquare>, 
/**
 * How long the side of a square is, m.
 */
square_m: number, 
/**
 * By vessel.
 */
vessels: Array<SummaryVessel>, 
/**
 * How many have which flag; flags that none has are left out.
 */
flags: Array<SummaryFlag>, 
/**
 * Detections whose times lie outside the plots: few, far from all others, and of receivers whose clock was not set, lost, or far
 * from the vessel's. They are counted in everything else; `whole_axis=true` shows them.
 */
outside: number, 
/**
 * How long receivers listened outside the plots, all together, s: likewise.
 */
listened_outside_s: number, 
/**
 * Detections reported before this are left out, as more than the server holds in memory are asked for, µs since 1970 UTC;
 * null where none are.
 */
left_out_before_us: number | null, 
/**
 * Of detections reported before this it is not known whether something confirms them, as not all of the day before them is
 * counted: none of them is called unconfirmed. µs since 1970 UTC; null where it is known of all.
 */
confirmed_from_us: number | null, 
/**
 * The server still reads: so far is counted what was reported from this time on, µs since 1970 UTC. Ask again soon. Null when
 * everything is counted.
 */
read_from_us: number | null, };

export type FlagCode = "unconfirmed" | "clock_not_set" | "clock_lost" | "clock_off" | "no_place" | "old_place" | "lines_lost";

export type SummaryBar = { 
/**
 * Where it begins, µs since 1970 UTC.
 */
from_us: number, 
/**
 * Detections.
 */
detections: number, 
/**
 * How many of those nothing confirms.
 */
unconfirmed: number, 
/**
 * How long receivers listened in it, all together, s; null where no receiver reported it, and where an area is chosen.
 */
listened_s: number | null, };

export type SummaryFlag = { 
/**
 * The flag.
 */
code: FlagCode, 
/**
 * How many.
 */
detections: number, };

export type SummarySquare = { 
/**
 * WGS-84 latitude of their middle, degrees, north positive.
 */
lat_deg: number, 
/**
 * WGS-84 longitude of their middle, degrees, east positive.
 */
lon_deg: number, 
/**
 * How many.
 */
detections: number, };

export type SummaryTag = { 
/**
 * Protocol and number, `S256-101`.
 */
tag: string, 
/**
 * The number.
 */
tag_id: number, 
/**
 * What the register calls it; empty where it does not know it.
 */
name: string, 
/**
 * The animal that carried it; empty where the register does not say.
 */
animal: string, 
/**
 * The project; likewise.
 */
project: string, 
/**
 * How often it was heard.
 */
detections: number, 
/**
 * How many of those nothing confirms.
 */
unconfirmed: number, 
/**
 * When first, µs since 1970 UTC.
 */
first_us: number, 
/**
 * When last.
 */
last_us: number, 
/**
 * Steps in which it was heard: number of the step, detections, and how many of those nothing confirms.
 */
marks: Array<[number, number, number]>, };

export type SummaryVessel = { 
/**
 * IMC address.
 */
system: number, 
/**
 * Detections.
 */
detections: number, 
/**
 * How long its receivers listened, all together, s; null where it did not report it, and where an area is chosen.
 */
listened_s: number | null, };

export type ReceiverClock = "set" | "not_set" | "disciplined" | "lost";

export type Detections = { 
/**
 * In order of the report, or the newest first.
 */
detections: Array<Detection>, 
/**
 * How to ask for those that did not fit; null when these are all.
 */
next: Next | null, };

export type TransportPeer = { 
/**
 * Its number, never used twice while the server runs.
 */
id: number, 
/**
 * The transport: `link`, `imcproxy`, `tcp` or `udp`.
 */
transport: string, 
/**
 * An address and port, or another name.
 */
name: string, 
/**
 * When it came, µs since 1970 UTC.
 */
since_us: number, 
/**
 * IMC addresses heard there that the caller may see, the most recent last.
 */
systems: Array<number>, 
/**
 * Packets that came from it.
 */
received: number, 
/**
 * Those of them that it may not send, or that are not packets.
 */
refused: number, 
/**
 * Packets for it.
 */
delivered: number, 
/**
 * Those of them that were dropped because it does not read.
 */
dropped: number, };

export type Entity = { 
/**
 * Number of the entity.
 */
entity: number, 
/**
 * Its label.
 */
label: string, 
/**
 * When it was first heard, µs since 1970 UTC.
 */
from_us: number, 
/**
 * When it was last heard, µs since 1970 UTC.
 */
last_us: number, };

export type EntityReport = { 
/**
 * Its label.
 */
entity: string, 
/**
 * When it last reported any of them, µs since 1970 UTC.
 */
time_us: number, 
/**
 * By name.
 */
parameters: Array<ParameterReport>, 
/**
 * How many more it reported than are kept.
 */
left_out: number, };

export type ExportSize = { 
/**
 * Rows; of a long table about so many.
 */
rows: number, 
/**
 * About so many bytes, not packed.
 */
bytes: number, 
/**
 * Whether that may be learnt from a sample; else it is counted.
 */
estimated: boolean, };

export type Field = { 
/**
 * Name in the message.
 */
name: string, 
/**
 * Number, text or nested message; null where it is not a number (NaN).
 */
value: unknown, 
/**
 * Unit, like `rad`; empty for none.
 */
unit: string, 
/**
 * The number's label, where it has one.
 */
meaning: string | null, };

export type Fix = { 
/**
 * When, by the vessel's clock, µs since 1970 UTC.
 */
time_us: number, 
/**
 * WGS-84 latitude, degrees, north positive.
 */
lat_deg: number, 
/**
 * WGS-84 longitude, degrees, east positive.
 */
lon_deg: number, 
/**
 * True heading, radians clockwise from north.
 */
heading_rad: number | null, 
/**
 * Course over ground, radians clockwise from north.
 */
course_rad: number | null, 
/**
 * Speed over ground, m/s.
 */
speed_mps: number | null, };

export type Gap = { 
/**
 * From when, µs since 1970 UTC.
 */
from_us: number, 
/**
 * Until when, µs since 1970 UTC.
 */
to_us: number, 
/**
 * Why the packets are missing.
 */
kind: GapKind, 
/**
 * Why, in words.
 */
reason: string, 
/**
 * When it was declared, by the shore's clock, µs since 1970 UTC; of a silence, when it ended.
 */
declared_us: number, };

export type GapKind = "not_recorded" | "not_delivered" | "lost";

export type Guard = { 
/**
 * `ok`, `warnings` or `refused`.
 */
outcome: string, 
/**
 * Why it is refused where no leg is the reason: `too-large` for the guard, `chart-unreadable`, or `no-go-areas` where the
 * chart lacks some; null else.
 */
cause: string | null, 
/**
 * All of it in one line.
 */
text: string, 
/**
 * Least depth in which the vessel may sail autonomously (m), against which the plan is checked.
 */
autonomous_m: number, 
/**
 * Whether these are limits that the vessel reported; else they are those of the server.
 */
of_vessel: boolean, 
/**
 * Why it is refused: a leg each; up to 100.
 */
reasons: Array<GuardReason>, 
/**
 * Parts that were not checked, or not well; up to 100.
 */
warnings: Array<GuardWarning>, };

export type GuardReason = { 
/**
 * Name of the maneuver.
 */
maneuver: string, 
/**
 * Which part of it: `transit`, `track`, `circle`, `station` or `drift`.
 */
part: string, 
/**
 * Where the leg begins; null where only a vessel's sentence is known of it.
 */
from: PlanPlace | null, 
/**
 * Where it ends; null like `from`.
 */
to: PlanPlace | null, 
/**
 * Number of the leg within the part, from 0.
 */
number: number, 
/**
 * `land`, `obstacle`, `unknown-depth`, `no-data`, `too-low`, `too-shallow`, `too-shallow-alone`, `entry-prohibited` or
 * `entry-restricted`.
 */
code: string, 
/**
 * In words.
 */
text: string, 
/**
 * Where it is worst: latitude (°).
 */
lat_deg: number, 
/**
 * Where it is worst: longitude (°).
 */
lon_deg: number, 
/**
 * Least charted depth there (m); null where it is not water of known depth.
 */
depth_m: number | null, 
/**
 * Class of the object that decides, an acronym of S-57.
 */
object: string | null, 
/**
 * Name of the area that may not be entered, where it has one and that is why.
 */
area: string | null, 
/**
 * The chart it is from.
 */
cell: string | null, 
/**
 * Compilation scale of that chart, 1 : this.
 */
scale: number | null, 
/**
 * Margin of the depth (m): negative = too shallow.
 */
margin_m: number | null, };

export type GuardWarning = { 
/**
 * Name of the maneuver; null for the plan itself.
 */
maneuver: string | null, 
/**
 * `start-unknown`, `unchecked`, `drifts-on`, `poor-chart`, `entry-prohibited` or `entry-restricted`.
 */
code: string, 
/**
 * What the code is about: of `unchecked` the kind of maneuver, of `poor-chart` the chart, of an area its name and chart;
 * null where nothing more is known.
 */
about: string | null, 
/**
 * In words.
 */
text: string, };

export type Import = { 
/**
 * Its number, growing.
 */
id: number, 
/**
 * The file's name.
 */
name: string, 
/**
 * Who uploaded it.
 */
person: string, 
/**
 * When it was uploaded, µs since 1970 UTC.
 */
since_us: number, 
/**
 * Its state.
 */
state: ImportState, 
/**
 * Bytes of the upload.
 */
upload_bytes: number, 
/**
 * Bytes of the log read so far, unpacked.
 */
read_bytes: number, 
/**
 * Packets found so far.
 */
packets: number, 
/**
 * Those of them that were new.
 */
added: number, 
/**
 * Bytes that are not packets.
 */
damaged_bytes: number, 
/**
 * What is wrong with the log, and what to do about it.
 */
problems: Array<ImportNote>, };

export type ImportState = "running" | "done" | "failed" | "cancelled";

export type ImportedPlan = { 
/**
 * The stored plan.
 */
stored: StoredPlan, 
/**
 * Parts of the file that were left out, and what is odd.
 */
notes: Array<ImportNote>, };

export type ImportNote = { 
/**
 * What, in English.
 */
text: string, 
/**
 * Of what pages make `text` in their reader's language; absent where it is English only.
 */
says?: Wording, };

export type Label = { 
/**
 * The number.
 */
value: number, 
/**
 * Its name.
 */
name: string, };

export type Lease = { 
/**
 * IMC address of the vessel.
 */
vessel: number, 
/**
 * Who has it; null while it is free.
 */
holder: LeaseHolder | null, 
/**
 * Who asked for it; null while no one has.
 */
waiting: LeaseWaiting | null, 
/**
 * What happened last; null while nothing has since the server started.
 */
last: LeaseChange | null, };

export type LeaseAction = "request" | "grant" | "decline" | "release" | "renew" | "take";

export type LeaseRequest = { 
/**
 * What to do with the control.
 */
action: LeaseAction, 
/**
 * Why, for the one who has control; needed to take over. 200 characters at most.
 */
reason: string, 
/**
 * Distinguishes the windows of a person; empty for scripts. 64 characters at most.
 */
window: string, };

export type LeaseChange = { 
/**
 * `granted`, `requested`, `handed over`, `granted without an answer`, `declined`, `withdrawn`, `released`,
 * `expired` or `taken over`.
 */
change: string, 
/**
 * Who did it, or whom it concerns where it happened automatically.
 */
who: string, 
/**
 * Who had control before, or whose request it was; null for no other person.
 */
from: string | null, 
/**
 * Why, in their words; may be empty.
 */
reason: string, 
/**
 * When, µs since 1970 UTC.
 */
time_us: number, };

export type LeaseHolder = { 
/**
 * The person's name.
 */
name: string, 
/**
 * Which of the person's windows.
 */
window: string, 
/**
 * Since when, µs since 1970 UTC.
 */
since_us: number, 
/**
 * Until when unless it is renewed, µs since 1970 UTC.
 */
until_us: number, };

export type LeaseWaiting = { 
/**
 * The person's name.
 */
name: string, 
/**
 * Which of the person's windows.
 */
window: string, 
/**
 * Why, in the person's words; may be empty.
 */
reason: string, 
/**
 * When it is granted without an answer, µs since 1970 UTC.
 */
granted_us: number, };

export type LinkStatus = { 
/**
 * IMC address of the vessel.
 */
vessel: number, 
/**
 * Whether the link is open.
 */
up: boolean, 
/**
 * Records that wait aboard to be delivered.
 */
backlog_records: number, 
/**
 * Age of the oldest of them, seconds.
 */
backlog_age_s: number, 
/**
 * From sending a record to the vessel knowing that it is kept, the last time, seconds.
 */
keeping_s: number, 
/**
 * The last round trip, seconds; null before the first.
 */
round_trip_s: number | null, 
/**
 * The vessel's clock minus the server's, seconds; null while unknown.
 */
clock_ahead_s: number | null, 
/**
 * That estimate is wrong by at most this, seconds.
 */
clock_uncertainty_s: number | null, 
/**
 * From recording aboard to receiving here, mean of the records of the last second, seconds; null without any.
 */
transit_s: number | null, 
/**
 * Bytes received over all connections.
 */
received_bytes: number, 
/**
 * Records that came again after they were received.
 */
repeated: number, 
/**
 * Connections opened so far.
 */
connections: number, 
/**
 * The sea chart aboard.
 */
chart: VesselChart, 
/**
 * The ways of a vessel that has several; null for one that has one.
 */
ways: LinkWays | null, };

export type LinkWay = { 
/**
 * Its name aboard.
 */
name: string, 
/**
 * Its bytes cost.
 */
metered: boolean, 
/**
 * `up`, `suspect` while it does not answer in time, or `down`.
 */
state: string, 
/**
 * From sending a message to knowing that it arrived, ms; null while unknown.
 */
round_trip_ms: number | null, 
/**
 * Of the last messages so many in a thousand were late by a packet that was lost.
 */
late_per_mille: number, 
/**
 * The fastest that it lately carried, B/s; null while unknown.
 */
rate_bytes_per_s: number | null, 
/**
 * Bytes of the day (UTC), both directions.
 */
today_bytes: number, 
/**
 * Bytes that it may carry in a day; null for no bound.
 */
daily_bytes: number | null, 
/**
 * What it leaves out to save data: `nothing`, `records`, `most`, or `all_but_last`.
 */
thinning: string, 
/**
 * How often it broke or stopped answering since the start of the vessel's program.
 */
failures: number, };

export type LinkWays = { 
/**
 * Place of the way that carries live values and commands; null for none.
 */
live: number | null, 
/**
 * Why: `only` one that stood, `better`, `cheaper`, `failover` from one that did not answer, `budget` of another used
 * up, or `none`.
 */
live_why: string, 
/**
 * Place of the way that carries records; null while they wait aboard.
 */
records: number | null, 
/**
 * Why, in the same words.
 */
records_why: string, 
/**
 * All ways, in the order of their places.
 */
ways: Array<LinkWay>, };

export type LiveAnswer = { "stop": LiveStopped };

export type LiveFrame = { 
/**
 * The server's clock, µs since 1970 UTC.
 */
now_us: number, 
/**
 * Whether this starts over: what is not in it is not there.
 */
snapshot: boolean, 
/**
 * Systems that changed since the last frame, ten times a second at most.
 */
systems: Array<System>, 
/**
 * Series with a new value; empty in the compact form.
 */
values: Array<Update>, 
/**
 * In the compact form, what the series are whose samples come for the first time since the snapshot.
 */
series: Array<LiveSeries>, 
/**
 * In the compact form, series with a new value.
 */
samples: Array<LiveSample>, 
/**
 * Events, in order.
 */
events: Array<Update>, 
/**
 * Tags that were heard, also those that a vessel reports late. One can come in several frames, with what was not
 * known of it before, and is the same by vessel and id.
 */
detections: Array<Detection>, 
/**
 * Values that newer ones replaced before they were sent.
 */
skipped: number, 
/**
 * Events that the server no longer had; the history has them.
 */
events_missed: number, 
/**
 * Who has control of a vessel, where that changed.
 */
leases: Array<Lease>, 
/**
 * Commands that got further, each with all of its stages.
 */
commands: Array<Command>, 
/**
 * Alarms that changed; those that are over come once more, as `normal`.
 */
alarms: Array<Alarm>, 
/**
 * Why nothing is recorded, or why the history lags behind, and what to do; null while all is well.
 */
recording: string | null, };

export type LiveRequest = { "subscribe": Subscription } | { "stop": LiveStop };

export type LiveSample = { 
/**
 * The number of its series.
 */
series: number, 
/**
 * The source's time, µs since 1970 UTC.
 */
time_us: number, 
/**
 * Arrival by the server's clock, µs since 1970 UTC.
 */
received_us: number, 
/**
 * Packets of the series since the server started.
 */
count: number, 
/**
 * Usual time between two of them, seconds; null while that is unknown.
 */
period_s: number | null, 
/**
 * Values of the fields, in their order; of a message that ends early, of the first fields only.
 */
values: unknown[], 
/**
 * Labels of the values, in their order; empty where none has one.
 */
meanings: Array<string | null>, };

export type LiveSeries = { 
/**
 * Its number on this connection, until the next snapshot.
 */
series: number, 
/**
 * IMC address of the source.
 */
system: number, 
/**
 * Number of the message.
 */
id: number, 
/**
 * Its abbreviation.
 */
abbrev: string, 
/**
 * Number of the entity within the source; 255 for none.
 */
entity: number, 
/**
 * Distinguishes several series of one entity; null where there is one.
 */
instance: number | null, 
/**
 * Names of its fields, in the order of the message. A series that is described again has more of them.
 */
names: Array<string>, 
/**
 * Their units; empty for none.
 */
units: Array<string>, };

export type LiveStop = { 
/**
 * IMC address of the vessel.
 */
vessel: number, 
/**
 * Distinguishes the windows of a person; empty for scripts. 64 bytes at most.
 */
window: string, 
/**
 * Names this stop; 1 to 64 bytes.
 */
key: string, };

export type LiveStopped = { 
/**
 * IMC address of the vessel.
 */
vessel: number, 
/**
 * As it was sent.
 */
key: string, 
/**
 * The order; null where it was refused.
 */
ordered: Ordered | null, 
/**
 * Why it was refused; null where it was not.
 */
refused: string | null, 
/**
 * Of what pages make `refused` in their reader's language; absent where it is English only.
 */
says?: Wording, };

export type Liveness = "live" | "late" | "stale" | "lost";

export type LogBook = { 
/**
 * In the order in which they were sent, or the newest first.
 */
entries: Array<LogBookEntry>, 
/**
 * How to ask for those that did not fit; null when these are all.
 */
next: Next | null, };

export type LogBookEntry = { 
/**
 * The entity that wrote it.
 */
entity: number, 
/**
 * When it was sent, µs since 1970 UTC.
 */
time_us: number, 
/**
 * When it was written, µs since 1970 UTC.
 */
written_us: number | null, 
/**
 * How serious it is: 0 information, 1 warning, 2 error, 3 critical, 4 debug.
 */
kind: number, 
/**
 * The name of that.
 */
kind_name: string | null, 
/**
 * The part of the vessel's program.
 */
context: string, 
/**
 * What it says.
 */
text: string, };

export type LogNote = { 
/**
 * Its number; never used again.
 */
id: number, 
/**
 * Grows with each correction, from 1.
 */
revision: number, 
/**
 * The time it is about, µs since 1970 UTC.
 */
time_us: number, 
/**
 * IMC address of the vessel it is about; null for a note on no vessel.
 */
vessel: number | null, 
/**
 * What people call the vessel; null where it has no name.
 */
vessel_name: string | null, 
/**
 * WGS 84 latitude of the place it is about, north positive; null without a place.
 */
lat_deg: number | null, 
/**
 * WGS 84 longitude of the place it is about, east positive; null without a place.
 */
lon_deg: number | null, 
/**
 * What it says.
 */
text: string, 
/**
 * Who wrote it.
 */
by: string, 
/**
 * When it was written, µs since 1970 UTC.
 */
written_us: number, 
/**
 * Who corrected it last; null if no one did. `/api/v1/logbook/{id}/earlier` gives its earlier texts.
 */
corrected: LogWord | null, 
/**
 * Who withdrew it; null while it is valid.
 */
withdrawn: LogWord | null, 
/**
 * Media type of its photo; null without a photo.
 */
photo: string | null, 
/**
 * Whether the requester may correct or withdraw it.
 */
may_change: boolean, };

export type LogNoteRequest = { 
/**
 * 1 to 4,000 characters.
 */
text: string, 
/**
 * IMC address of the vessel it is about; null for a note on no vessel.
 */
vessel: number | null, 
/**
 * WGS 84 latitude of the place it is about; null without a place.
 */
lat_deg: number | null, 
/**
 * WGS 84 longitude, with the latitude.
 */
lon_deg: number | null, 
/**
 * The time it is about, µs since 1970 UTC; the present when left out.
 */
time_us: number | null, };

export type LogNoteChange = { 
/**
 * The revision that is corrected; 409 when there is a newer one.
 */
revision: number, 
/**
 * Its new text. The time stays unchanged when left out.
 */
note: LogNoteRequest, };

export type LogNoteRevision = { 
/**
 * Its revision.
 */
revision: number, 
/**
 * The time it was about, µs since 1970 UTC.
 */
time_us: number, 
/**
 * IMC address of the vessel; null for a note on no vessel.
 */
vessel: number | null, 
/**
 * WGS 84 latitude; null without a place.
 */
lat_deg: number | null, 
/**
 * WGS 84 longitude; null without a place.
 */
lon_deg: number | null, 
/**
 * What it said.
 */
text: string, 
/**
 * Who wrote that, and when.
 */
written: LogWord, };

export type LogNotes = { 
/**
 * The newest first, by the time they are about.
 */
notes: Array<LogNote>, 
/**
 * Give this as `before` to ask for older notes; null on the last page.
 */
next: string | null, };

export type LogWord = { 
/**
 * The person.
 */
by: string, 
/**
 * When, µs since 1970 UTC.
 */
time_us: number, };

export type Me = { 
/**
 * Name to log in with.
 */
name: string, 
/**
 * Permissions by vessel.
 */
permissions: Array<Permission>, };

export type Mission = { 
/**
 * Its number; never used again.
 */
id: number, 
/**
 * Grows with each change, from 1.
 */
revision: number, 
/**
 * Its contents; of its vessels those that the requester may see.
 */
mission: MissionRequest, 
/**
 * Who wrote it down first, and when.
 */
written: LogWord, 
/**
 * Who changed it last; null if no one did.
 */
changed: LogWord | null, 
/**
 * Who withdrew it; null while it is valid.
 */
withdrawn: LogWord | null, 
/**
 * Whether the requester may change or withdraw it.
 */
may_change: boolean, };

export type MissionRequest = { 
/**
 * 1 to 120 characters in one line.
 */
name: string, 
/**
 * Who took part; at most 500 characters.
 */
people: string, 
/**
 * Its purpose; at most 2,000 characters.
 */
purpose: string, 
/**
 * Remarks; at most 4,000 characters.
 */
notes: string, 
/**
 * IMC addresses of its vessels, 1 to 32.
 */
vessels: Array<number>, 
/**
 * From this time on, µs since 1970 UTC.
 */
from_us: number, 
/**
 * Before this time, µs since 1970 UTC; null while it lasts.
 */
to_us: number | null, };

export type NoGoArea = { 
/**
 * Its number; never used again.
 */
id: number, 
/**
 * Grows with each change, from 1.
 */
revision: number, 
/**
 * What it is.
 */
area: NoGoAreaRequest, 
/**
 * Who closed it first, and when.
 */
written: LogWord, 
/**
 * Who last changed it or closed it again; null if no one did.
 */
changed: LogWord | null, 
/**
 * Who lifted it; null while it is closed.
 */
lifted: LogWord | null, };

export type NoGoAreaChange = { 
/**
 * The revision that is changed; 409 when there is a newer one.
 */
revision: number, 
/**
 * Its new content.
 */
area: NoGoAreaRequest, 
/**
 * Whether it is closed from now on; false lifts it.
 */
closed: boolean, };

export type NoGoAreaRequest = { 
/**
 * What people call it: 1 to 80 characters in one line.
 */
name: string, 
/**
 * Why it is closed; at most 500 characters.
 */
reason: string, 
/**
 * Latitude and longitude (°) of its corners, 3 to 200; the last joins the first, and its sides do not cross. Sides are
 * straight on a Mercator map.
 */
corners: Array<[number, number]>, };

export type NoGoAreas = { 
/**
 * Those that are closed, by name; then, where they were asked for, those that were lifted last, newest first.
 */
areas: Array<NoGoArea>, 
/**
 * Whether plans and routes ashore are checked against exactly the closed ones. Vessels check by the sea chart
 * aboard, which they get from here.
 */
in_force: boolean, 
/**
 * Why they are not in force, for people; null where they are.
 */
trouble: string | null, 
/**
 * Whether the requester may close, change and lift areas.
 */
may_change: boolean, };

export type NoGoAreasRequest = { 
/**
 * 1 to 200 of them.
 */
areas: Array<NoGoAreaRequest>, };

export type MissionChange = { 
/**
 * The revision that is changed; 409 when there is a newer one.
 */
revision: number, 
/**
 * Its new contents.
 */
mission: MissionRequest, };

export type MissionSummary = { 
/**
 * Up to when, µs since 1970 UTC: its end, or the present while it lasts.
 */
to_us: number, 
/**
 * Vessel by vessel, of those that the requester may see.
 */
vessels: Array<MissionVessel>, };

export type MissionVessel = { 
/**
 * IMC address.
 */
vessel: number, 
/**
 * What people call it; null where it has no name.
 */
vessel_name: string | null, 
/**
 * Time of its first recorded position, µs since 1970 UTC; null without positions.
 */
first_us: number | null, 
/**
 * Time of its last recorded position, µs since 1970 UTC; null without positions.
 */
last_us: number | null, 
/**
 * Distance from position to position, one a second (m); over gaps the straight way.
 */
distance_m: number, 
/**
 * Time with recorded positions (s): gaps of more than a minute do not count.
 */
recorded_s: number, 
/**
 * The battery's first charge (%), by FuelLevel; null if it was not recorded.
 */
battery_first_percent: number | null, 
/**
 * Its last charge (%).
 */
battery_last_percent: number | null, 
/**
 * Energy taken from its batteries (Wh), by voltage and current of each that reports its charge; null if none reports all three.
 * Gaps of more than a minute do not count.
 */
energy_wh: number | null, 
/**
 * Names of the plans that it sailed, in the order in which they were begun first.
 */
plans: Array<string>, 
/**
 * Detections.
 */
detections: number, 
/**
 * Different tags among them.
 */
tags: number, };

export type Missions = { 
/**
 * Those that began last first.
 */
missions: Array<Mission>, 
/**
 * Give this as `before` to ask for older missions; null on the last page.
 */
next: string | null, };

export type NewToken = { 
/**
 * What it is for.
 */
label: string, 
/**
 * The most it may do.
 */
role: Role, 
/**
 * Limits it to a vessel; null for all.
 */
vessel: number | null, 
/**
 * Days until it ends.
 */
days: number, };

export type Next = { 
/**
 * The new `from_us`.
 */
from_us: number, 
/**
 * The new `to_us`.
 */
to_us: number, 
/**
 * The new `skip`.
 */
skip: number, };

export type NoControl = { "why": "free" } | { "why": "held", 
/**
 * The person who has it.
 */
by: string, } | { "why": "other_window" } | { "why": "expired" } | { "why": "nobody_waits" } | { "why": "asked", 
/**
 * The person who has it.
 */
by: string, 
/**
 * Within how many seconds they get an answer.
 */
within_s: number, } | { "why": "reason_needed", 
/**
 * Who has it, and is informed.
 */
by: string, } | { "why": "too_long", 
/**
 * Letters that it may have.
 */
most: number, };

export type Order = { "kind": "plan.start", 
/**
 * Its name.
 */
plan_id: string, } | { "kind": "plan.stop", } | { "kind": "goto", 
/**
 * WGS-84 latitude, degrees, north positive.
 */
lat_deg: number, 
/**
 * WGS-84 longitude, degrees, east positive.
 */
lon_deg: number, 
/**
 * Speed, m/s, 0.1 to 5.
 */
speed_mps: number, } | { "kind": "plan.delete", 
/**
 * Its name.
 */
plan_id: string, } | { "kind": "plan.list", } | { "kind": "plan.get", 
/**
 * Its name.
 */
plan_id: string, } | { "kind": "parameters.query", 
/**
 * The entity's label.
 */
entity: string, } | { "kind": "parameters.set", 
/**
 * The entity's label.
 */
entity: string, 
/**
 * Names and values.
 */
values: Array<Parameter>, } | { "kind": "parameters.save", 
/**
 * The entity's label.
 */
entity: string, };

export type OrderRequest = { 
/**
 * What to do.
 */
order: Order, 
/**
 * The window that has control; empty for scripts.
 */
window: string, };

export type Ordered = { 
/**
 * The command's number. What was sent several times with one key has one number.
 */
id: number, 
/**
 * When it was handed on, by the server's clock, µs since 1970 UTC.
 */
time_us: number, 
/**
 * Whether it was sent: a transport leads to the vessel.
 */
reached: boolean, 
/**
 * Whether the vessel was not heard lately: the order is sent, perhaps once more, as soon as the vessel is heard
 * within ten minutes.
 */
waits: boolean, 
/**
 * Whether a vessel of this address has a name here or was heard since the server started. Where not, the address may be
 * a mistake; the stop is sent all the same.
 */
known: boolean, };

export type Parameter = { 
/**
 * Its name.
 */
name: string, 
/**
 * Its value, as text.
 */
value: string, };

export type ParameterAbout = { 
/**
 * Its section of the configuration.
 */
section: string, 
/**
 * Its effect, in a line.
 */
doc: string, 
/**
 * Symbol of its unit; empty for pure numbers.
 */
unit: string, 
/**
 * How many numbers it is, with commas between; null for text.
 */
items: number | null, 
/**
 * The least allowed; null for any.
 */
min: number | null, 
/**
 * The greatest allowed; null for any.
 */
max: number | null, 
/**
 * Its value where the configuration says nothing.
 */
default: string, 
/**
 * Whether it can be changed while the vessel runs; else in its configuration file only.
 */
live: boolean, 
/**
 * Why a change deserves a second look; null for none.
 */
caution: string | null, };

export type ParameterReport = { 
/**
 * Its name.
 */
name: string, 
/**
 * Its value, as text.
 */
value: string, 
/**
 * Its value from the next start; null where the vessel does not report it.
 */
saved: string | null, 
/**
 * Whether the value is longer than what is kept of it, so that it is not to be written back.
 */
cut: boolean, 
/**
 * When it was reported, µs since 1970 UTC.
 */
time_us: number, 
/**
 * What it means; null for parameters of other programs than Lutra's.
 */
about: ParameterAbout | null, };

export type Permission = { 
/**
 * IMC address of the vessel; null for all vessels.
 */
vessel: number | null, 
/**
 * What may be done.
 */
role: Role, };

export type Person = { 
/**
 * Name to log in with.
 */
name: string, 
/**
 * Permissions by vessel.
 */
permissions: Array<Permission>, 
/**
 * Whether a one-time password is still to be changed.
 */
must_change_password: boolean, 
/**
 * When the account was made, µs since 1970 UTC.
 */
created_us: number, };

export type PlanAboard = { 
/**
 * Its name.
 */
plan_id: string, 
/**
 * Bytes of its specification.
 */
size: number, 
/**
 * When it was changed, by the vessel's clock, µs since 1970 UTC.
 */
changed_us: number | null, 
/**
 * Who changed it.
 */
changed_by: string, 
/**
 * MD5 of its specification as IMC has it, hexadecimal.
 */
md5: string, };

export type PlanChange = { 
/**
 * The revision that the change was made from. Another in the store refuses the change: 409, with the newer
 * plan as `newer` beside `error`.
 */
revision: number, 
/**
 * Whether it is only kept, not saved. What is saved must have no problems.
 */
draft: boolean, 
/**
 * All of it as it shall be.
 */
plan: PlanDocument, };

export type PlanCheck = { 
/**
 * Errors that keep it from being sailed; none for a valid plan. A vessel's own limits may be narrower.
 */
problems: Array<PlanTrouble>, 
/**
 * Warnings for its author.
 */
warnings: Array<PlanTrouble>, 
/**
 * What all of it takes, from its first place on; of a plan that repeats, one round. Empty while it has problems.
 */
total: PlanCost, 
/**
 * What each maneuver takes, and where it leads, in their order. Empty while there are problems.
 */
maneuvers: Array<PlanLeg>, 
/**
 * MD5 of the plan as it would be aboard, 32 hexadecimal digits; null while it has problems.
 */
digest: string | null, 
/**
 * The guard's verdict, the way to its first place left out; null while it has problems
 * and where there is no chart. An upload or start is judged again with the way from where the vessel is.
 */
guard: Guard | null, };

export type PlanCost = { 
/**
 * Way (m).
 */
length_m: number | null, 
/**
 * Time (s).
 */
duration_s: number | null, 
/**
 * Energy from the battery (J), an estimate.
 */
energy_j: number | null, };

export type PlanDocument = { 
/**
 * Its name, ashore and aboard; 1 to 60 bytes.
 */
name: string, 
/**
 * What it is for; up to 500 letters.
 */
description: string, 
/**
 * IMC address of the vessel it is for; null for any.
 */
vessel: number | null, 
/**
 * Whether it starts over at its end.
 */
repeat: boolean, 
/**
 * What to do, in this order.
 */
maneuvers: Array<PlanStep>, };

export type PlanGiven = { 
/**
 * Its name.
 */
plan_id: string, 
/**
 * MD5 of its specification as IMC has it, hexadecimal.
 */
md5: string, 
/**
 * How many maneuvers it has.
 */
maneuvers: number, 
/**
 * Latitude and longitude where its first maneuver begins, degrees; null where that is not a place.
 */
first_deg: [number, number] | null, 
/**
 * All of it, as IMC JSON.
 */
specification: unknown, };

export type PlanLeg = { 
/**
 * Its name.
 */
id: string, 
/**
 * What it takes, with the way to it.
 */
cost: PlanCost, 
/**
 * Where it leads, to be drawn.
 */
places: Array<PlanPlace>, };

export type PlanPlace = { 
/**
 * Latitude (°).
 */
lat_deg: number, 
/**
 * Longitude (°).
 */
lon_deg: number, };

export type PlanRevision = { 
/**
 * Its number.
 */
revision: number, 
/**
 * Who made it.
 */
author: string, 
/**
 * When, µs since 1970 UTC.
 */
saved_us: number, 
/**
 * Whether it was only kept, not saved.
 */
draft: boolean, };

export type PlanSpeed = { 
/**
 * How much of it.
 */
value: number, 
/**
 * Of what.
 */
unit: SpeedUnit, };

export type PlanStep = { 
/**
 * Its name, which no other maneuver of the plan has; 1 to 60 bytes.
 */
id: string, 
/**
 * How fast.
 */
speed: PlanSpeed, 
/**
 * What to do.
 */
task: PlanTask, };

export type PlanSummary = { 
/**
 * Its number ashore.
 */
id: number, 
/**
 * Its name, ashore and aboard.
 */
name: string, 
/**
 * IMC address of the vessel it is for; null for any.
 */
vessel: number | null, 
/**
 * Grows with every change.
 */
revision: number, 
/**
 * Whether its latest changes were only saved automatically.
 */
draft: boolean, 
/**
 * Who changed it last.
 */
author: string, 
/**
 * When, µs since 1970 UTC.
 */
updated_us: number, 
/**
 * How many maneuvers.
 */
maneuvers: number, 
/**
 * How many problems keep it from being sailed.
 */
problems: number, 
/**
 * MD5 of the plan as it would be aboard, 32 hexadecimal digits; null where it cannot be.
 */
digest: string | null, 
/**
 * What all of it takes.
 */
total: PlanCost, };

export type PlanTask = { "kind": "goto", 
/**
 * Where to.
 */
at: PlanPlace, } | { "kind": "follow_path", 
/**
 * The points; up to 2000.
 */
points: Array<PlanPlace>, } | { "kind": "station_keeping", 
/**
 * Around where.
 */
at: PlanPlace, 
/**
 * How far the vessel may drift (m).
 */
radius_m: number, 
/**
 * How long after the arrival (s); 0 until stopped.
 */
duration_s: number, } | { "kind": "loiter", 
/**
 * Around where.
 */
at: PlanPlace, 
/**
 * Radius of the circle (m).
 */
radius_m: number, 
/**
 * How long on the circle (s); 0 until stopped.
 */
duration_s: number, 
/**
 * Which way round.
 */
clockwise: boolean, } | { "kind": "rows", 
/**
 * Where the first row starts.
 */
at: PlanPlace, 
/**
 * Direction of the first row (°).
 */
bearing_deg: number, 
/**
 * How far the sideways step is turned clockwise (°).
 */
cross_angle_deg: number, 
/**
 * Extent across the rows (m).
 */
width_m: number, 
/**
 * Length of a row (m).
 */
length_m: number, 
/**
 * Distance between rows (m).
 */
step_m: number, 
/**
 * How far rows are overrun before turning (m), 0 to 255.
 */
curve_offset_m: number, 
/**
 * Share of the step that is taken at the upper end of rows (%); 100 is the same at both.
 */
alternation_percent: number, 
/**
 * Turns are squares instead of diagonals.
 */
square_curve: boolean, 
/**
 * The first curve goes to the right.
 */
curve_right: boolean, };

export type PlanTrouble = { 
/**
 * Name of the maneuver; null for the plan itself.
 */
maneuver: string | null, 
/**
 * What, for programs; `other` where there are words only.
 */
code: string, 
/**
 * The code's subject: a quantity, a kind of maneuver; null where it is the whole plan.
 */
about: string | null, 
/**
 * The figures of the code by their names, SI units.
 */
values: { [key in string]?: number }, 
/**
 * What, in words.
 */
text: string, };

export type PlanUnderWay = { 
/**
 * Its name; null while the vessel sails none, or has not reported one.
 */
plan_id: string | null, 
/**
 * The maneuver that the vessel is at; empty where it does not say.
 */
maneuver: string, 
/**
 * From where the plan is known: `vessel`, `shore` (the vessel's digest is that of a plan kept ashore), or null for
 * not at all.
 */
source: string | null, 
/**
 * MD5 of its specification as IMC has it, hexadecimal; null while it is not known.
 */
digest: string | null, 
/**
 * Where its maneuvers lead, in the order in which they are sailed.
 */
legs: Array<RouteLeg>, 
/**
 * Whether it begins again at its end.
 */
repeats: boolean, 
/**
 * Why it is not drawn; null where it is.
 */
trouble: string | null, };

export type PlanUploadRequest = { 
/**
 * IMC address of the vessel.
 */
vessel: number, 
/**
 * The revision that is meant; another in the store refuses the upload: 409.
 */
revision: number, 
/**
 * The window that has control of the vessel; empty for scripts.
 */
window: string, };

export type PlansAboard = { 
/**
 * When they were reported, µs since 1970 UTC; null if never.
 */
time_us: number | null, 
/**
 * By name.
 */
plans: Array<PlanAboard>, };

export type Recorded = { 
/**
 * IMC address of the source.
 */
system: number, 
/**
 * Abbreviation of the message.
 */
abbrev: string, 
/**
 * How many.
 */
count: number, 
/**
 * Time of the first, µs since 1970 UTC.
 */
first_us: number, 
/**
 * Time of the last, µs since 1970 UTC.
 */
last_us: number, };

export type RecordedDay = { 
/**
 * IMC address of the source.
 */
system: number, 
/**
 * Its name, as it announced itself last; its address where it never did.
 */
name: string, 
/**
 * Midnight of the UTC day on which it came, µs since 1970.
 */
day_us: number, 
/**
 * First time by the source's clock, µs since 1970 UTC.
 */
first_us: number, 
/**
 * Last time by the source's clock, µs since 1970 UTC.
 */
last_us: number, 
/**
 * How many packets.
 */
packets: number, 
/**
 * Bytes of these packets in the archive; 0 for a day that was removed there, and is in the history still.
 */
bytes: number, };

export type Recording = { 
/**
 * Why nothing can be recorded at the moment, and what to do; null while all is well.
 */
trouble: string | null, 
/**
 * Why the history does not hold all that is archived; null while it does.
 */
history_behind: string | null, 
/**
 * Packets recorded since the server started.
 */
recorded: number, 
/**
 * Packets that could not wait for the disk any longer and are not recorded.
 */
not_recorded: number, 
/**
 * Bytes that wait for the disk.
 */
waiting_bytes: number, 
/**
 * Bytes of other transports than the link that may wait; what comes beyond is not recorded.
 */
waiting_bytes_most: number, };

export type Refusal = { 
/**
 * The reason, as a code.
 */
error: RefusalReason, };

export type RefusalReason = { 
/**
 * Stays the same: `grounding`, `no_control`, `called_off`, `refused`, `not_found`, …
 */
code: string, 
/**
 * In English, for scripts and logs: what is wrong and what to do.
 */
text: string, 
/**
 * Of `grounding`: the verdict, with the legs and their worst spots.
 */
guard?: Guard, 
/**
 * Of `no_control`: why.
 */
control?: NoControl, 
/**
 * Of what pages make `text` in their reader's language, where it is no fixed sentence and neither of the two above.
 */
says?: Wording, };

export type RegisterAnimal = { 
/**
 * Its name or number in the study.
 */
name: string, 
/**
 * The name of its project.
 */
project: string, 
/**
 * Scientific name of the species.
 */
scientific_name: string, 
/**
 * The species' number in WoRMS (AphiaID).
 */
aphia_id: number | null, 
/**
 * Common name of the species.
 */
common_name: string, 
/**
 * Length, mm.
 */
length_mm: number | null, 
/**
 * Which length that is, such as `total` or `fork`.
 */
length_type: string, 
/**
 * Weight, g.
 */
weight_g: number | null, 
/**
 * `F`, `M` or `U` for unknown.
 */
sex: string, 
/**
 * Stage of life, such as `smolt`.
 */
life_stage: string, 
/**
 * When it was caught.
 */
capture_us: number | null, 
/**
 * Where it was caught, in words.
 */
capture_place: string, 
/**
 * WGS-84 latitude of the catch, degrees.
 */
capture_lat_deg: number | null, 
/**
 * WGS-84 longitude of the catch, degrees.
 */
capture_lon_deg: number | null, 
/**
 * When it was released with its tag.
 */
release_us: number | null, 
/**
 * Where it was released, in words.
 */
release_place: string, 
/**
 * WGS-84 latitude of the release, degrees.
 */
release_lat_deg: number | null, 
/**
 * WGS-84 longitude of the release, degrees.
 */
release_lon_deg: number | null, 
/**
 * The group with which it was released.
 */
release_group: string, 
/**
 * Remarks.
 */
notes: string, };

export type RegisterAnswer = { 
/**
 * Counts changes of the whole register.
 */
version: number, 
/**
 * Entries, by kind and name.
 */
entries: Array<RegisterEntry>, };

export type RegisterChange = { 
/**
 * The revision that is changed; 409 when there is a newer one.
 */
revision: number, 
/**
 * Its new content. The kind cannot change.
 */
record: RegisterRecord, };

export type RegisterDeployment = { 
/**
 * What people call it; receiver and begin when left empty.
 */
name: string, 
/**
 * The name of the receiver.
 */
receiver: string, 
/**
 * IMC address of the vessel.
 */
vessel: number | null, 
/**
 * The name of the project.
 */
project: string, 
/**
 * From when on.
 */
from_us: number | null, 
/**
 * Until when; null while it lasts.
 */
to_us: number | null, 
/**
 * Depth of the hydrophone below the surface, m.
 */
depth_m: number | null, 
/**
 * WGS 84 latitude of a fixed station, degrees; null on a vessel that moves.
 */
lat_deg: number | null, 
/**
 * Its longitude, degrees.
 */
lon_deg: number | null, 
/**
 * Remarks.
 */
notes: string, };

export type RegisterEntry = { 
/**
 * Its number; never used again.
 */
id: number, 
/**
 * Grows with each change, from 1.
 */
revision: number, 
/**
 * Its contents.
 */
record: RegisterRecord, 
/**
 * Who changed it last, and when.
 */
written: LogWord, 
/**
 * Whether the requester may change or delete it.
 */
may_change: boolean, };

export type RegisterFieldChange = { 
/**
 * Its column.
 */
column: string, 
/**
 * Its old value, as in a file.
 */
before: string, 
/**
 * Its new value.
 */
after: string, };

export type RegisterImport = { 
/**
 * Whether it is done.
 */
applied: boolean, 
/**
 * Counts changes of the whole register.
 */
version: number, 
/**
 * Entries that are new.
 */
added: number, 
/**
 * Entries that say something else.
 */
changed: number, 
/**
 * Unchanged entries.
 */
same: number, 
/**
 * Problems of the file; nothing is imported while there is one.
 */
problems: Array<RegisterProblem>, 
/**
 * New and changed entries, line by line.
 */
changes: Array<RegisterImportChange>, };

export type RegisterImportChange = { 
/**
 * Line of the file, the header being 1.
 */
line: number, 
/**
 * Name of the entry.
 */
name: string, 
/**
 * Whether it is new.
 */
is_new: boolean, 
/**
 * Values that differ, or are new.
 */
fields: Array<RegisterFieldChange>, };

export type RegisterKind = "project" | "person" | "animal" | "tag" | "receiver" | "deployment";

export type RegisterPerson = { 
/**
 * The name as it is published.
 */
name: string, 
/**
 * Where they work.
 */
affiliation: string, 
/**
 * ORCID, such as `0000-0002-1825-0097`; its check digit is checked.
 */
orcid: string, 
/**
 * Remarks.
 */
notes: string, };

export type RegisterProblem = { 
/**
 * Line of the file, the header being 1; null where an entry that is not in the file would be wrong.
 */
line: number | null, 
/**
 * Column; empty where the whole line is meant.
 */
column: string, 
/**
 * What is wrong, and what to do.
 */
text: string, 
/**
 * Of what pages make `text` in their reader's language; absent where it is English only.
 */
says?: Wording, };

export type RegisterProject = { 
/**
 * Its short name or code, as portals know it.
 */
name: string, 
/**
 * Its title.
 */
title: string, 
/**
 * The name of the person who leads it.
 */
principal_investigator: string, 
/**
 * The name of the person who answers questions.
 */
contact: string, 
/**
 * How to cite it.
 */
citation: string, 
/**
 * The licence of its data, by SPDX, such as `CC-BY-4.0`.
 */
licence: string, 
/**
 * Remarks.
 */
notes: string, };

export type RegisterReceiver = { 
/**
 * What people call it; model and serial number when left empty.
 */
name: string, 
/**
 * Serial number, as in its lines.
 */
serial: number | null, 
/**
 * Model as portals write it, such as `TBR700`.
 */
model: string, 
/**
 * Who made it.
 */
manufacturer: string, 
/**
 * Remarks.
 */
notes: string, };

export type RegisterRecord = { "kind": "project" } & RegisterProject | { "kind": "person" } & RegisterPerson | { "kind": "animal" } & RegisterAnimal | { "kind": "tag" } & RegisterTag | { "kind": "receiver" } & RegisterReceiver | { "kind": "deployment" } & RegisterDeployment;

export type RegisterTag = { 
/**
 * What people call it; protocol and number when left empty.
 */
name: string, 
/**
 * The name of its project.
 */
project: string, 
/**
 * Protocol as receivers name it, such as `R64K` or `OPs`.
 */
protocol: string, 
/**
 * Its number.
 */
tag_id: number | null, 
/**
 * Carrier, kHz; any when null.
 */
frequency_khz: number | null, 
/**
 * Frequency and code space as portals write them, such as `A69-1303`; made of protocol and frequency when empty.
 */
codespace: string, 
/**
 * Serial number of the maker.
 */
serial: string, 
/**
 * Who made it.
 */
manufacturer: string, 
/**
 * Its model.
 */
model: string, 
/**
 * What it measures, such as `depth`.
 */
sensor_type: string, 
/**
 * The value is slope · count + intercept.
 */
sensor_slope: number | null, 
/**
 * See the slope.
 */
sensor_intercept: number | null, 
/**
 * Unit of the value, such as `m`.
 */
sensor_unit: string, 
/**
 * Least time from ping to ping, s.
 */
interval_min_s: number | null, 
/**
 * Greatest time from ping to ping, s.
 */
interval_max_s: number | null, 
/**
 * The name of the animal that carries it; empty for a reference tag.
 */
animal: string, 
/**
 * From when on; from the beginning when null.
 */
from_us: number | null, 
/**
 * Until when; to the end when null.
 */
to_us: number | null, 
/**
 * Remarks.
 */
notes: string, };

export type Role = "viewer" | "researcher" | "operator" | "admin";

export type RouteLeg = { 
/**
 * Its name.
 */
id: string, 
/**
 * What it is, in a word.
 */
kind: string, 
/**
 * Its places, in order; none for one that follows another system or stays.
 */
places: Array<PlanPlace>, 
/**
 * The circle that the vessel keeps within, m; null for none.
 */
radius_m: number | null, };

export type SampleRow = { 
/**
 * Its time, by the sender's clock, µs since 1970 UTC.
 */
time_us: number, 
/**
 * When it first came ashore, µs since 1970 UTC.
 */
received_us: number, 
/**
 * Numbers, texts, nested messages; null for what is not a number or absent.
 */
values: unknown[], };

export type Samples = { 
/**
 * The columns of a row.
 */
fields: Array<SeriesField>, 
/**
 * The samples, in order of time.
 */
rows: Array<SampleRow>, 
/**
 * How to ask for those that did not fit; null when these are all.
 */
next: Next | null, };

export type SeaRoute = { 
/**
 * Latitude and longitude (°) of its corners, start and goal included.
 */
points: Array<[number, number]>, 
/**
 * From each point to the next.
 */
legs: Array<SeaRouteLeg>, 
/**
 * Length (m).
 */
length_m: number, 
/**
 * The speed through the water that time and energy are reckoned with (m/s).
 */
speed_mps: number, 
/**
 * Length on which the current is not known (m): beyond the grid or its times, and after such water where the current
 * changes with time. Time and energy are null then. A route by time or energy has no more of it than the shortest one.
 */
current_unknown_m: number, 
/**
 * Whether the current is too strong somewhere. Time and energy are null then.
 */
current_too_strong: boolean, 
/**
 * How long it takes at the speed through the water (s); null where the current is too strong or not known.
 */
duration_s: number | null, 
/**
 * Energy from the battery (Wh), by a rough model of an Otter; null where the current is too strong or not known, and at
 * speeds that the model does not know.
 */
energy_wh: number | null, 
/**
 * Least charted depth within the clearance (m).
 */
least_depth_m: number | null, 
/**
 * Distance to the nearest danger, land or shallow water (m); null beyond 5 km.
 */
least_clearance_m: number | null, 
/**
 * Ends and places to pass too near land, shallow water or a danger, which were moved to the nearest open water.
 */
moved: Array<SeaRouteMoved>, 
/**
 * Whether the guard lets a vessel sail every leg autonomously.
 */
guarded: boolean, 
/**
 * The first leg that it refuses, by its number, and why; null where it refuses none.
 */
guard: GuardReason | null, 
/**
 * Legs where danger is nearer than the vessel may be off its track; null where there is room everywhere.
 */
narrow: SeaRouteNarrow | null, 
/**
 * Whether only part of the water was looked at in full, as the charts hold too much of it: other water may hold a shorter
 * route. Its legs are checked like those of any route.
 */
part_only: boolean, };

export type SeaRouteAnswer = { 
/**
 * Least depth that was asked for (m).
 */
asked_depth_m: number, 
/**
 * Clearance that was asked for (m).
 */
asked_clearance_m: number, 
/**
 * The route.
 */
route: SeaRoute | null, 
/**
 * The shortest route, to compare with; null where the route is the shortest one itself.
 */
shortest: SeaRoute | null, 
/**
 * Other routes, as far as they were asked for and differ from this one and each other: the shortest first.
 */
alternatives: Array<SeaRoute>, 
/**
 * The reason that no route exists.
 */
refusal: SeaRouteRefusal | null, 
/**
 * Duration of the planning (ms).
 */
took_ms: number, };

export type SeaRouteRequest = { 
/**
 * Latitude and longitude (°) of the start, of places to pass in this order, and of the goal; 2 to 50.
 */
points: Array<[number, number]>, 
/**
 * IMC address of the vessel whose limits hold; null for those of the server.
 */
vessel: number | null, 
/**
 * Least depth (m); null for what the guard demands.
 */
least_depth_m: number | null, 
/**
 * How far to keep from all that is not deep enough (m), 0 to 500; null for what the guard demands.
 */
clearance_m: number | null, 
/**
 * Turning radius of the vessel (m), 0 to 2000: turns keep to the asked water too, or their leg says that they do not;
 * null where it is not known.
 */
turn_radius_m: number | null, 
/**
 * How far the vessel may be off its track before its path monitor ends the plan (m), 0 to 500: the route says where danger
 * is nearer than that. Null for 25, as the Otters have it.
 */
stray_m: number | null, 
/**
 * What the route is good for.
 */
objective: SeaRouteObjective, 
/**
 * Water shallower than this (m) costs more, so that a route keeps to deeper water where that is worth the way;
 * null for no such preference.
 */
prefer_depth_m: number | null, 
/**
 * Water nearer than this (m), 0 to 500, to land, dangers and water that is not deep enough costs more; null for no such
 * preference.
 */
prefer_off_m: number | null, 
/**
 * How many times as much such water costs, 1 to 100; null for 3. In water that is both, the two surcharges add.
 */
prefer_factor: number | null, 
/**
 * How many times as much a metre costs in traffic lanes, separation zones and deep-water routes of the chart, 1 to 100; the
 * surcharge is twice as large straight against the direction of a lane. The route keeps out of them where the way round is
 * not far. 1 does not mind them; null for 3.
 */
traffic_factor: number | null, 
/**
 * Speed through the water that time and energy are reckoned with (m/s); null for 1.5. For the least energy the greatest
 * one.
 */
speed_mps: number | null, 
/**
 * Areas to avoid, to stay within, or with a speed limit; up to 50, of which one may be to stay within, with 1000 corners
 * and 2000 km of borders in all.
 */
zones: Array<SeaRouteZone>, 
/**
 * The current that time and energy are reckoned in; null for none.
 */
current: SeaRouteCurrent | null, 
/**
 * A current that changes from place to place, in place of a steady one; null for none.
 */
current_grid: SeaRouteCurrentGrid | null, 
/**
 * When the route begins, µs since 1970 UTC: which of the grid's times count. Null for now.
 */
depart_us: number | null, 
/**
 * How many other routes to look for, 0 to 3, that pass islands and shoals on the other side; they are not looked for
 * where there are places to pass.
 */
alternatives: number, 
/**
 * If no route exists, look for a smaller depth and clearance that give one, and for what is in the way; it can take some
 * seconds.
 */
explain: boolean, 
/**
 * A name for this question, 8 to 64 letters, digits and hyphens that no other question has: as long as it is worked on,
 * `GET /api/v1/chart/route/{name}` says how far it has come. Null for none.
 */
progress: string | null, };

export type SeaRouteTraffic = { 
/**
 * `lane`, `separation_zone`, `junction` or `deep_water`.
 */
kind: string, 
/**
 * Whether the leg leads against the direction of the lane.
 */
against: boolean, };

export type SeaRouteZone = { 
/**
 * What it is for.
 */
kind: SeaRouteZoneKind, 
/**
 * Latitude and longitude (°) of its corners, 3 to 200; the last joins the first, and its sides do not cross.
 */
corners: Array<[number, number]>, 
/**
 * Greatest speed through the water (m/s) in an area of the kind `limit`; null in others.
 */
most_mps: number | null, };

export type SeaRouteZoneKind = "avoid" | "within" | "limit";

export type SeaRouteCurrent = { 
/**
 * Where it flows to (°), clockwise from true north.
 */
set_deg: number, 
/**
 * How fast (m/s), 0 to 10.
 */
drift_mps: number, };

export type SeaRouteCurrentGrid = { 
/**
 * Times, rising, µs since 1970 UTC.
 */
times_us: Array<number>, 
/**
 * Latitudes (°), rising, two or more.
 */
lats_deg: Array<number>, 
/**
 * Longitudes (°), rising, two or more; also beyond 180.
 */
lons_deg: Array<number>, 
/**
 * Current to the true east (m/s) by time, then latitude, then longitude, 100000 values at most; null where not known.
 */
east_mps: Array<number | null>, 
/**
 * Current to the true north (m/s), as to the east.
 */
north_mps: Array<number | null>, };

export type SeaRouteObjective = "shortest" | "fastest" | "least_energy";

export type SeaRouteLeg = { 
/**
 * Length (m).
 */
length_m: number, 
/**
 * Course over ground at its start (°), clockwise from true north.
 */
course_deg: number, 
/**
 * How long it takes (s); null where the current is too strong or not known.
 */
duration_s: number | null, 
/**
 * The slowest speed limit (m/s) of the areas that the leg enters or touches, where it is slower than the route's speed;
 * null where no limit is. A plan with one speed for the route does not keep it.
 */
limit_mps: number | null, 
/**
 * The ordered traffic that the leg enters or touches, where it is minded; null for none.
 */
traffic: SeaRouteTraffic | null, 
/**
 * Energy from the battery (Wh); null where the current is too strong or not known.
 */
energy_wh: number | null, 
/**
 * Least charted depth within the clearance (m).
 */
least_depth_m: number | null, 
/**
 * Where that is: latitude and longitude (°).
 */
least_depth_at: [number, number], 
/**
 * Distance to the nearest danger, land or shallow water (m); null beyond 5 km.
 */
clearance_m: number | null, 
/**
 * Why a vessel of the asked turning radius leaves the asked water in the turn at the end of this leg, for people; null
 * if it does not, and where no radius was asked for.
 */
turn_text: string | null, };

export type SeaRouteMoved = { 
/**
 * `start`, `via` for a place to pass, or `goal`.
 */
end: string, 
/**
 * Number of the place to pass, from 1; null at an end.
 */
via: number | null, 
/**
 * How far (m).
 */
distance_m: number, 
/**
 * Why, for people.
 */
text: string, };

export type SeaRouteNarrow = { 
/**
 * Distance that leaves room (m): how far the vessel may be off its track, its hull, and the uncertainty of its position.
 */
needed_m: number, 
/**
 * The narrowest leg, by its number from 0.
 */
leg: number, 
/**
 * Its distance to the nearest danger, land or shallow water (m).
 */
least_m: number, 
/**
 * How many legs they are.
 */
legs: number, 
/**
 * How long they are together (m).
 */
length_m: number, };

export type SeaRouteClosed = { 
/**
 * As the code of a [`GuardReason`], or `zone` in an area to avoid or outside of one to stay within; `too-shallow` also where it is deep enough and a danger is too near.
 */
code: string, 
/**
 * Least charted depth there (m); null where it is not water of known depth.
 */
depth_m: number | null, 
/**
 * How far the end may be moved (m).
 */
may_move_m: number, };

export type SeaRouteGaveUp = { 
/**
 * So many tiles of the chart were searched.
 */
tiles: number, 
/**
 * Whether its time was used up; else it may search no more of the chart.
 */
out_of_time: boolean, };

export type SeaRoutePassable = { 
/**
 * The greatest least depth (m) that gives one with this clearance; null if none was found.
 */
depth_m: number | null, 
/**
 * Where that one is shallowest: latitude and longitude (°).
 */
shallowest_at: [number, number] | null, 
/**
 * The greatest clearance (m) that gives one of this depth; null if none was found.
 */
clearance_m: number | null, 
/**
 * Where the gap is that allows no more clearance: latitude and longitude (°) of its middle.
 */
gap_at: [number, number] | null, 
/**
 * How wide that gap is (m).
 */
gap_width_m: number | null, 
/**
 * Whether there is one without the areas where entry is prohibited or restricted.
 */
by_rule_alone: boolean, 
/**
 * Whether there is one without the areas that the request itself avoids or keeps within.
 */
by_zones_alone: boolean, };

export type SeaRouteProgress = { 
/**
 * Other routes are planned before it.
 */
waiting: boolean, 
/**
 * Tiles of the chart that were searched for it; 0 as long as it is not known to be a long way.
 */
tiles: number, 
/**
 * The search stops after so many; 0 as long as it is not known to be a long way. Most ways are found long before.
 */
most_tiles: number, 
/**
 * Time since it was asked (s).
 */
spent_s: number, 
/**
 * Planning stops after so long (s), without the time that it waited.
 */
most_s: number, };

export type SeaRouteRefusal = { 
/**
 * For programs: `closed_start`, `closed_via` (at a place to pass), `closed_goal`, `no_way`, `not_found` (not all water was
 * looked at), `gave_up` (the search for a long way was stopped), `too_far`, `not_confirmed` or `failed`.
 */
code: string, 
/**
 * For people: what is in the way, and what to do.
 */
text: string, 
/**
 * Which stretch between two of the asked points, from 0.
 */
stretch: number, 
/**
 * The nearest place that can be reached: latitude and longitude (°).
 */
nearest: [number, number] | null, 
/**
 * How far open water, or that place, is from where it was asked for (m).
 */
gap_m: number | null, 
/**
 * The obstacle at a closed end; null for another reason.
 */
closed: SeaRouteClosed | null, 
/**
 * How far start and goal are apart, and how far they may be (m); null for another reason.
 */
apart_m: [number, number] | null, 
/**
 * How far from the start it was looked, where not all water was looked at (m); null for another reason.
 */
looked_m: number | null, 
/**
 * What a search that was stopped had come to; null for another reason.
 */
gave_up: SeaRouteGaveUp | null, 
/**
 * Number of the place to pass that is closed, from 1; null for another reason.
 */
via: number | null, 
/**
 * Where start and goal are too far apart: places on a way between them, if one is known. Routes by way of them have shorter stretches.
 */
by: Array<[number, number]>, 
/**
 * Changes that would give a route; null where that was not asked for.
 */
passable: SeaRoutePassable | null, };

export type Series = { 
/**
 * IMC address of the source.
 */
system: number, 
/**
 * Abbreviation of the message, or its number where the catalogue has none.
 */
message: string, 
/**
 * Number of the message.
 */
id: number, 
/**
 * Number of the entity; 255 for none.
 */
entity: number, 
/**
 * The entity's last label.
 */
label: string | null, 
/**
 * The values of each sample, in order; empty where the catalogue does not know the message.
 */
fields: Array<SeriesField>, 
/**
 * How many samples.
 */
count: number, 
/**
 * How many of them have no believable time (before 2000, or from 2100 on); plots leave them out.
 */
undated: number, 
/**
 * Time of the first that has a believable time, µs since 1970 UTC.
 */
first_us: number | null, 
/**
 * Time of the last that has a believable time, µs since 1970 UTC.
 */
last_us: number | null, 
/**
 * Mean time between two of them, seconds; null for fewer than two.
 */
period_s: number | null, };

export type SeriesField = { 
/**
 * Name in the message, such as `psi`.
 */
name: string, 
/**
 * What it is, in words.
 */
title: string, 
/**
 * Unit, like `rad`; empty for none.
 */
unit: string, 
/**
 * The type of its values.
 */
kind: ValueKind, 
/**
 * Labels of its numbers; empty where they are plain numbers. Of bit fields, the bits.
 */
labels: Array<Label>, };

export type Session = { 
/**
 * Number to revoke it by.
 */
id: number, 
/**
 * The person.
 */
person: string, 
/**
 * Login, µs since 1970 UTC.
 */
created_us: number, 
/**
 * Last request (to the minute), µs since 1970 UTC.
 */
seen_us: number, 
/**
 * Address at login.
 */
address: string, 
/**
 * The browser's user agent.
 */
agent: string, };

export type ShelveRequest = { 
/**
 * For how many minutes, 1 to 720.
 */
minutes: number, 
/**
 * Why, in 1 to 300 characters.
 */
reason: string, };

export type SpeedUnit = "mps" | "rpm" | "percent";

export type StoredPlan = { 
/**
 * Its number ashore.
 */
id: number, 
/**
 * Grows with every change; a change names the one it was made from.
 */
revision: number, 
/**
 * Whether its latest changes were only saved automatically, not by a person.
 */
draft: boolean, 
/**
 * Who changed it last.
 */
author: string, 
/**
 * When, µs since 1970 UTC.
 */
updated_us: number, 
/**
 * What is drawn.
 */
plan: PlanDocument, 
/**
 * What it takes, and what is wrong with it.
 */
check: PlanCheck, };

export type Subscription = { 
/**
 * IMC addresses; null for all that the person may see.
 */
systems?: Array<number>, 
/**
 * Abbreviations of messages like `EstimatedState`; null for all, empty for none.
 */
messages?: Array<string>, 
/**
 * Of systems that are not listed, these messages; null where nothing is wanted of them.
 */
of_others?: Array<string>, 
/**
 * Whether events and detections are wanted.
 */
events: boolean, 
/**
 * Milliseconds between two frames at least, 2 to 10000.
 */
every_ms: number, 
/**
 * Whether frames come in the compact form: `series` and `samples` in place of `values`, in binary messages.
 */
compact: boolean, };

export type System = { 
/**
 * IMC address.
 */
address: number, 
/**
 * Its name as announced, or as given by people; null while it has none.
 */
name: string | null, 
/**
 * Kind by its Announce, like `USV` or `CCU`.
 */
kind: string | null, 
/**
 * How long it has been silent, in words.
 */
liveness: Liveness, 
/**
 * Its last packet by the server's clock, µs since 1970 UTC.
 */
heard_us: number, 
/**
 * Transports through which it was heard, the latest first.
 */
transports: Array<string>, 
/**
 * Its position, where it reported one.
 */
fix: Fix | null, 
/**
 * Entities' labels by number.
 */
entities: { [key in number]?: string }, };

export type TeleopPhase = "idle" | "starting" | "locked" | "ready" | "steering";

export type TeleopSample = { 
/**
 * Greater than that of the sample before.
 */
seq: number, 
/**
 * When it was made, by a clock of the browser that does not step, ms.
 */
made_ms: number, 
/**
 * Another number than before when the input device has shown life: a gamepad's own timestamp.
 */
change: number, 
/**
 * The stamp that came last; null before the first.
 */
stamp_us: number | null, 
/**
 * How long ago it came, ms.
 */
stamp_held_ms: number, 
/**
 * Whether the dead-man is held.
 */
held: boolean, 
/**
 * Ahead, −1 to 1.
 */
thrust: number, 
/**
 * To starboard, −1 to 1.
 */
turn: number, };

export type TeleopMessage = { "begin": { 
/**
 * Distinguishes the windows of a person.
 */
window: string, } } | { "sample": TeleopSample } | { "stop": { 
/**
 * What happened.
 */
why: TeleopStop, } } | { "end": Record<string, never> };

export type TeleopStop = "hidden" | "unfocused" | "gamepad_gone" | "two_devices" | "unmoved" | "person";

export type TeleopStatus = { 
/**
 * The server's steady clock, µs, to be brought back by the next sample.
 */
stamp_us: number, 
/**
 * How far it is.
 */
phase: TeleopPhase, 
/**
 * Why it stopped, did not begin or ended, in words; it stays until the sticks steer again.
 */
why: string, 
/**
 * Of what pages make `why` in their reader's language; absent where it is empty or the vessel's own words.
 */
why_says?: Wording, 
/**
 * The remedy, in words; empty where the only one is to start over.
 */
remedy: string, 
/**
 * The same of `remedy`.
 */
remedy_says?: Wording, 
/**
 * From the browser to the vessel and back, ms; null while unknown.
 */
round_trip_ms: number | null, 
/**
 * Whether the vessel's own link is counted in: it is known for the vessel link alone.
 */
with_vessel: boolean, 
/**
 * Whether the round trip is longer than is good.
 */
slow: boolean, 
/**
 * Most thrust and turn at present, of 1.
 */
cap: number, };

export type Token = { 
/**
 * Number to revoke it by.
 */
id: number, 
/**
 * What it is for.
 */
label: string, 
/**
 * For whom it acts; null for a vessel's link.
 */
person: string | null, 
/**
 * The vessel it is limited to; null for all.
 */
vessel: number | null, 
/**
 * The most it may do; null for a vessel's link.
 */
role: Role | null, 
/**
 * When it was made, µs since 1970 UTC.
 */
created_us: number, 
/**
 * When it ends, µs since 1970 UTC.
 */
expires_us: number | null, 
/**
 * When it was last used (to the minute), µs since 1970 UTC.
 */
used_us: number | null, };

export type TokenMade = { 
/**
 * Number to revoke it by.
 */
id: number, 
/**
 * For the header `Authorization: Bearer SECRET`.
 */
secret: string, };

export type TrackPoint = { 
/**
 * When, by the vessel's clock, µs since 1970 UTC.
 */
time_us: number, 
/**
 * WGS-84 latitude, degrees, north positive.
 */
lat_deg: number, 
/**
 * WGS-84 longitude, degrees, east positive.
 */
lon_deg: number, };

export type Update = { 
/**
 * IMC address of the source.
 */
system: number, 
/**
 * Number of the message.
 */
id: number, 
/**
 * Its abbreviation, like `EstimatedState`.
 */
abbrev: string, 
/**
 * Number of the entity within the source; 255 for none.
 */
entity: number, 
/**
 * Distinguishes several series of one entity, like port and starboard; null where there is one.
 */
instance: number | null, 
/**
 * The source's time, µs since 1970 UTC.
 */
time_us: number, 
/**
 * Arrival by the server's clock, µs since 1970 UTC.
 */
received_us: number, 
/**
 * Packets of the series since the server started; 0 for an event.
 */
count: number, 
/**
 * Usual time between two of them, seconds; null while that is unknown.
 */
period_s: number | null, 
/**
 * Values by field, in the order of the message.
 */
fields: Array<Field>, };

export type ValueKind = "integer" | "enumeration" | "bits" | "real" | "text" | "raw" | "nested";

export type Vessel = { 
/**
 * IMC address.
 */
address: number, 
/**
 * Name on the pages.
 */
name: string, };

export type VesselQuery = { "about": "parameters", 
/**
 * Labels of entities; none for all that the vessel has.
 */
entities: Array<string>, } | { "about": "plans", } | { "about": "plan", 
/**
 * Its name.
 */
plan_id: string, };

export type VesselQuerySent = { 
/**
 * When it was sent, by the server's clock, µs since 1970 UTC.
 */
time_us: number, 
/**
 * How many packets it took; 0 where the same was asked less than 2 s ago.
 */
packets: number, 
/**
 * Whether a transport leads to the vessel at present; else the query reached no one.
 */
reached: boolean, 
/**
 * Labels of the entities that were asked for their parameters.
 */
entities: Array<string>, };

export type VesselParameters = { 
/**
 * By the entity's label.
 */
entities: Array<EntityReport>, 
/**
 * Whether they come from the history: the vessel has reported none since the server started.
 */
recorded: boolean, };

export type VesselChart = { 
/**
 * `same` as ashore, `fetching` the shore's, `waiting` until the vessel rests, `failed` to take it, `declined` by
 * the vessel's configuration, `other` than ashore, `none`, or `unknown`.
 */
state: string, 
/**
 * The same in words, with the reason where it could not be taken.
 */
text: string, 
/**
 * Contents of the chart in force aboard; null for none.
 */
edition: string | null, 
/**
 * SHA-256 of its file in hexadecimal digits; null for none.
 */
digest: string | null, 
/**
 * How it differs from the shore's, and the state of the transfer; null where it is the same, or not known.
 */
difference: ChartDifference | null, 
/**
 * When the vessel reported it, µs since 1970 UTC; null while unknown.
 */
told_us: number | null, };

export type Wording = { 
/**
 * Like `There is no person {name}.`
 */
template: string, 
/**
 * What is put in the places, by their names.
 */
values: { [key in string]?: string }, 
/**
 * Places that hold texts with words of their own, each text on a line; absent where there are none.
 */
parts?: { [key in string]?: Array<Wording> }, };
