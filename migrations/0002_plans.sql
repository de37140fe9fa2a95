-- Plans that people draw. Times are microseconds since 1970 UTC.

-- vessel is an IMC address, or null for any. A deleted plan stays for a while, to be restored.
CREATE TABLE plan (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    name TEXT NOT NULL COLLATE NOCASE,
    vessel INTEGER,
    revision INTEGER NOT NULL,
    deleted_us INTEGER
) STRICT;
CREATE UNIQUE INDEX plan_name ON plan (name) WHERE deleted_us IS NULL;

-- body is a plan document (api::PlanDocument) as JSON. draft: kept by itself, not saved by somebody.
CREATE TABLE plan_revision (
    plan INTEGER NOT NULL REFERENCES plan ON DELETE CASCADE,
    revision INTEGER NOT NULL,
    author TEXT NOT NULL,
    saved_us INTEGER NOT NULL,
    draft INTEGER NOT NULL,
    body TEXT NOT NULL,
    PRIMARY KEY (plan, revision)
) STRICT, WITHOUT ROWID;
