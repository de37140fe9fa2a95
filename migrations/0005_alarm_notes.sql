-- What happened to alarms: raised, acknowledged, over and so on. what, kind and priority are words of api::AlarmNote; vessel
-- and vessel_name, as it was called then, are NULL for the server itself, by is empty for nobody. Times are microseconds since 1970 UTC.
CREATE TABLE alarm_note (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    time_us INTEGER NOT NULL,
    alarm INTEGER NOT NULL,
    vessel INTEGER,
    vessel_name TEXT,
    kind TEXT NOT NULL,
    priority TEXT NOT NULL,
    what TEXT NOT NULL,
    by TEXT NOT NULL,
    text TEXT NOT NULL
) STRICT;

CREATE INDEX alarm_note_time ON alarm_note (time_us);
