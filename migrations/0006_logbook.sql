-- The log book that people keep. Nothing is deleted: a note that is corrected leaves its earlier state in log_note_before, one that is
-- withdrawn is marked. vessel is NULL for a note on no vessel, lat_deg and lon_deg together for one without a place; folded is
-- the text in small letters, which is searched; photo is the media type of the file logbook/ID in the data folder. Times are
-- microseconds since 1970 UTC.
CREATE TABLE log_note (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    revision INTEGER NOT NULL,
    time_us INTEGER NOT NULL,
    vessel INTEGER,
    lat_deg REAL,
    lon_deg REAL,
    text TEXT NOT NULL,
    folded TEXT NOT NULL,
    person INTEGER NOT NULL,
    by TEXT NOT NULL,
    written_us INTEGER NOT NULL,
    corrected_by TEXT,
    corrected_us INTEGER,
    withdrawn_by TEXT,
    withdrawn_us INTEGER,
    photo TEXT,
    photo_bytes INTEGER NOT NULL DEFAULT 0
) STRICT;

CREATE INDEX log_note_time ON log_note (time_us, id);
CREATE INDEX log_note_photo ON log_note (photo_bytes) WHERE photo_bytes > 0;

-- Earlier texts of notes, with who wrote them and when.
CREATE TABLE log_note_before (
    note INTEGER NOT NULL REFERENCES log_note,
    revision INTEGER NOT NULL,
    time_us INTEGER NOT NULL,
    vessel INTEGER,
    lat_deg REAL,
    lon_deg REAL,
    text TEXT NOT NULL,
    by TEXT NOT NULL,
    written_us INTEGER NOT NULL,
    PRIMARY KEY (note, revision)
) STRICT, WITHOUT ROWID;
