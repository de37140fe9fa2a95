-- Messages about alarms that people asked for. notice_rule says who gets what and how: way is 'mail' or 'webhook', target an
-- address of mail or a URL, secret what a webhook's messages are signed by, least the least priority, vessel NULL for all,
-- after_s how long an alarm stands without an acknowledgement before it is told, also_over whether its end is told too. A rule
-- ends with its person, its messages with their rule.
CREATE TABLE notice_rule (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    person INTEGER NOT NULL REFERENCES person ON DELETE CASCADE,
    way TEXT NOT NULL,
    target TEXT NOT NULL,
    secret TEXT NOT NULL,
    least TEXT NOT NULL,
    vessel INTEGER,
    after_s INTEGER NOT NULL,
    also_over INTEGER NOT NULL,
    made_us INTEGER NOT NULL
) STRICT;

CREATE INDEX notice_rule_person ON notice_rule (person);

-- A message: body is the JSON of what it tells, alarm NULL for one that a person tried out. While outcome is NULL it waits
-- until due_us; words is what the other side said last. Times are microseconds since 1970 UTC.
CREATE TABLE notice (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    rule INTEGER NOT NULL REFERENCES notice_rule ON DELETE CASCADE,
    alarm INTEGER,
    what TEXT NOT NULL,
    body TEXT NOT NULL,
    made_us INTEGER NOT NULL,
    due_us INTEGER NOT NULL,
    tries INTEGER NOT NULL DEFAULT 0,
    words TEXT NOT NULL DEFAULT '',
    outcome TEXT,
    outcome_us INTEGER
) STRICT;

CREATE INDEX notice_rule_made ON notice (rule, made_us);
CREATE INDEX notice_waiting ON notice (due_us) WHERE outcome IS NULL;
