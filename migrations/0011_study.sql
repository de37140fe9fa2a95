-- The register of studies: projects, people, animals, tags, receivers, deployments. body is the JSON of api::RegisterRecord; kind
-- is its word, folded its name in small letters, unique among its kind. What an entry said before it was changed or deleted
-- is kept in study_entry_before, with who said so and when, and who ended it and when. changes counts all that was ever
-- changed, so that files made of it know whether they are still the same. Times are microseconds since 1970 UTC.
CREATE TABLE study_entry (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    kind TEXT NOT NULL,
    folded TEXT NOT NULL,
    revision INTEGER NOT NULL,
    body TEXT NOT NULL,
    by TEXT NOT NULL,
    written_us INTEGER NOT NULL,
    UNIQUE (kind, folded)
) STRICT;

CREATE TABLE study_entry_before (
    entry INTEGER NOT NULL,
    revision INTEGER NOT NULL,
    body TEXT NOT NULL,
    by TEXT NOT NULL,
    written_us INTEGER NOT NULL,
    ended_by TEXT NOT NULL,
    ended_us INTEGER NOT NULL,
    PRIMARY KEY (entry, revision)
) STRICT, WITHOUT ROWID;

CREATE TABLE study_state (changes INTEGER NOT NULL) STRICT;
INSERT INTO study_state VALUES (0);
