-- Datasets that researchers make of detections, and links by which others get them. draft and body are the JSON of
-- api::DatasetDraft and api::DatasetVersion; draft is null while nothing waits for publication. A row of dataset_version is written
-- once and never changed. Whose vessels stand in the question decides who may see and change a dataset.
-- Of a link's address only the SHA-256 is kept, of its password the argon2id hash. Times are microseconds since 1970 UTC.
CREATE TABLE dataset (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    revision INTEGER NOT NULL,
    draft TEXT,
    by TEXT NOT NULL,
    made_us INTEGER NOT NULL,
    withdrawn_by TEXT,
    withdrawn_us INTEGER,
    reason TEXT
) STRICT;

CREATE TABLE dataset_version (
    dataset INTEGER NOT NULL REFERENCES dataset,
    number INTEGER NOT NULL,
    body TEXT NOT NULL,
    PRIMARY KEY (dataset, number)
) STRICT, WITHOUT ROWID;

CREATE TRIGGER dataset_version_stays BEFORE UPDATE ON dataset_version
BEGIN SELECT RAISE(ABORT, 'a published version of a dataset never changes'); END;

CREATE TRIGGER dataset_version_remains BEFORE DELETE ON dataset_version
BEGIN SELECT RAISE(ABORT, 'a published version of a dataset is never deleted'); END;

-- body is the JSON of api::DatasetShare without what is counted and what revoking adds.
CREATE TABLE dataset_share (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    dataset INTEGER NOT NULL REFERENCES dataset,
    hash BLOB NOT NULL UNIQUE,
    password TEXT,
    expires_us INTEGER NOT NULL,
    body TEXT NOT NULL,
    views INTEGER NOT NULL DEFAULT 0,
    downloads INTEGER NOT NULL DEFAULT 0,
    used_us INTEGER,
    revoked_by TEXT,
    revoked_us INTEGER
) STRICT;

CREATE INDEX dataset_share_of ON dataset_share (dataset);

CREATE TABLE dataset_visit (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    share INTEGER NOT NULL REFERENCES dataset_share,
    time_us INTEGER NOT NULL,
    address TEXT NOT NULL,
    what TEXT NOT NULL,
    file TEXT NOT NULL
) STRICT;

CREATE INDEX dataset_visit_of ON dataset_visit (share, id);
CREATE INDEX dataset_visit_kind ON dataset_visit (share, what, id);
