-- What an alarm said, as JSON of api::AlarmSaying, so that its words can be made in the reader's language. NULL in what was
-- kept before, which has its English text.
ALTER TABLE alarm_note ADD COLUMN says TEXT;
-- What a person made by a key of their page, so that the same sent again makes nothing new. made: 0 a note of the log book,
-- 1 a mission; id is its number.
CREATE TABLE made_by_key (
    person INTEGER NOT NULL,
    made INTEGER NOT NULL,
    key TEXT NOT NULL,
    id INTEGER NOT NULL,
    PRIMARY KEY (person, made, key)
) STRICT, WITHOUT ROWID;
