-- People, what they may do, and what they did. Times are microseconds since 1970 UTC. Secrets are kept as
-- SHA-256 (random ones) or argon2id (passwords).

CREATE TABLE person (
    id INTEGER PRIMARY KEY,
    name TEXT NOT NULL UNIQUE COLLATE NOCASE,
    password TEXT NOT NULL,
    must_change INTEGER NOT NULL,
    created_us INTEGER NOT NULL
) STRICT;

-- vessel is an IMC address, or -1 for all vessels. role: 1 viewer, 2 researcher, 3 operator, 4 admin.
CREATE TABLE permission (
    person INTEGER NOT NULL REFERENCES person ON DELETE CASCADE,
    vessel INTEGER NOT NULL,
    role INTEGER NOT NULL,
    PRIMARY KEY (person, vessel)
) STRICT, WITHOUT ROWID;

CREATE TABLE session (
    id INTEGER PRIMARY KEY,
    hash BLOB NOT NULL UNIQUE,
    person INTEGER NOT NULL REFERENCES person ON DELETE CASCADE,
    created_us INTEGER NOT NULL,
    seen_us INTEGER NOT NULL,
    address TEXT NOT NULL,
    agent TEXT NOT NULL
) STRICT;
CREATE INDEX session_person ON session (person);

-- Browsers in which a person was logged in before: strangers' guesses do not slow these down.
CREATE TABLE device (
    hash BLOB PRIMARY KEY,
    person INTEGER NOT NULL REFERENCES person ON DELETE CASCADE,
    used_us INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
CREATE INDEX device_person ON device (person, used_us);

CREATE TABLE vessel (
    address INTEGER PRIMARY KEY,
    name TEXT NOT NULL UNIQUE COLLATE NOCASE,
    created_us INTEGER NOT NULL
) STRICT;

-- A token for the API acts for its person, with at most its role on its vessel (-1: all). A token for the link
-- belongs to a vessel and has no person and no role.
CREATE TABLE token (
    id INTEGER PRIMARY KEY,
    hash BLOB NOT NULL UNIQUE,
    label TEXT NOT NULL,
    person INTEGER REFERENCES person ON DELETE CASCADE,
    vessel INTEGER NOT NULL,
    role INTEGER,
    created_us INTEGER NOT NULL,
    expires_us INTEGER,
    used_us INTEGER,
    CHECK ((person IS NULL) = (role IS NULL))
) STRICT;

CREATE TABLE audit (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    time_us INTEGER NOT NULL,
    actor TEXT NOT NULL,
    address TEXT NOT NULL,
    action TEXT NOT NULL,
    subject TEXT NOT NULL,
    outcome TEXT NOT NULL
) STRICT;
