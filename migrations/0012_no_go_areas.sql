-- No-go areas that people draw. body is the JSON of api::NoGoAreaRequest. An area that is changed leaves its earlier body in
-- no_go_area_before, one that is lifted is marked and can be closed again. Times are microseconds since 1970 UTC.
CREATE TABLE no_go_area (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    revision INTEGER NOT NULL,
    body TEXT NOT NULL,
    by TEXT NOT NULL,
    written_us INTEGER NOT NULL,
    changed_by TEXT,
    changed_us INTEGER,
    lifted_by TEXT,
    lifted_us INTEGER
) STRICT;

CREATE TABLE no_go_area_before (
    area INTEGER NOT NULL REFERENCES no_go_area,
    revision INTEGER NOT NULL,
    body TEXT NOT NULL,
    by TEXT NOT NULL,
    written_us INTEGER NOT NULL,
    PRIMARY KEY (area, revision)
) STRICT, WITHOUT ROWID;
