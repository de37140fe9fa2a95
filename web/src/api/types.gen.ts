// Made from crates/api by `make types`. Do not edit.

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
 * Who.
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

export type Field = { 
/**
 * Name in the message.
 */
name: string, 
/**
 * Number, text or nested message; null where it is no number (NaN).
 */
value: unknown, 
/**
 * Unit, like `rad`; empty for none.
 */
unit: string, 
/**
 * What the number stands for, where it stands for something.
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

export type LiveFrame = { 
/**
 * The server's clock, µs since 1970 UTC.
 */
now_us: number, 
/**
 * Whether this begins anew: what is not in it is not there.
 */
snapshot: boolean, 
/**
 * All systems that the client wants, as they are now.
 */
systems: Array<System>, 
/**
 * Series with a new value.
 */
values: Array<Update>, 
/**
 * Events, in order.
 */
events: Array<Update>, 
/**
 * Values that newer ones replaced before they were sent.
 */
skipped: number, 
/**
 * Events that the server no longer had; the history has them.
 */
events_missed: number, };

export type LiveRequest = { "subscribe": Subscription };

export type Liveness = "live" | "late" | "stale" | "lost";

export type Me = { 
/**
 * Name to log in with.
 */
name: string, 
/**
 * What may be done where.
 */
permissions: Array<Permission>, };

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
 * What may be done where.
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

export type Role = "viewer" | "researcher" | "operator" | "admin";

export type Session = { 
/**
 * Number to revoke it by.
 */
id: number, 
/**
 * Who.
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
 * What the browser calls itself.
 */
agent: string, };

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
 * Whether events are wanted.
 */
events: boolean, 
/**
 * Milliseconds between two frames at least, 5 to 10000.
 */
every_ms: number, };

export type System = { 
/**
 * IMC address.
 */
address: number, 
/**
 * What it calls itself, or what people call it; null while nobody has said.
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
 * Doors through which it was heard, the latest first.
 */
doors: Array<string>, 
/**
 * Where it is, when it said so.
 */
fix: Fix | null, 
/**
 * Entities' labels by number.
 */
entities: { [key in number]?: string }, };

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
 * What tells several series of one entity apart, like port and starboard; null where nothing has to.
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

export type Vessel = { 
/**
 * IMC address.
 */
address: number, 
/**
 * Name on the pages.
 */
name: string, };
