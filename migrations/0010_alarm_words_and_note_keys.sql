-- What an alarm said, as JSON of api::AlarmSaying, so that its words can be made in the reader's language. NULL in what was
-- kept before, which has its English text.
ALTER TABLE alarm_note ADD COLUMN says TEXT;
-- The key that a page made for a note: the same person sending the same key again gets the note that is there. NULL without one.
ALTER TABLE log_note ADD COLUMN key TEXT;
CREATE UNIQUE INDEX log_note_key ON log_note (person, key) WHERE key IS NOT NULL;
