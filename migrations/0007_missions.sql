-- Missions that people record: who did what with which vessels, from when to when. body is the JSON of api::MissionAsk, and
-- from_us and to_us (NULL while it goes on) stand beside it to be asked for. A mission that is changed leaves its earlier body in
-- mission_before, one that is withdrawn is marked. Times are microseconds since 1970 UTC.
CREATE TABLE mission (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    revision INTEGER NOT NULL,
    from_us INTEGER NOT NULL,
    to_us INTEGER,
    body TEXT NOT NULL,
    by TEXT NOT NULL,
    written_us INTEGER NOT NULL,
    changed_by TEXT,
    changed_us INTEGER,
    withdrawn_by TEXT,
    withdrawn_us INTEGER
) STRICT;

CREATE INDEX mission_from ON mission (from_us, id);

CREATE TABLE mission_vessel (
    mission INTEGER NOT NULL REFERENCES mission,
    vessel INTEGER NOT NULL,
    PRIMARY KEY (mission, vessel)
) STRICT, WITHOUT ROWID;

CREATE TABLE mission_before (
    mission INTEGER NOT NULL REFERENCES mission,
    revision INTEGER NOT NULL,
    body TEXT NOT NULL,
    by TEXT NOT NULL,
    written_us INTEGER NOT NULL,
    PRIMARY KEY (mission, revision)
) STRICT, WITHOUT ROWID;
