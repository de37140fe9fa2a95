-- The one account that can open a link. Null: anyone with the address.
ALTER TABLE dataset_share ADD COLUMN person INTEGER;

CREATE INDEX dataset_share_person ON dataset_share (person) WHERE person IS NOT NULL;

-- SQLite may give the number of a removed account to a new one. So a link ends with its account.
CREATE TRIGGER dataset_share_ends_with_person AFTER DELETE ON person
BEGIN
    UPDATE dataset_share SET revoked_by = OLD.name, revoked_us = CAST(unixepoch('subsec') * 1000000 AS INTEGER)
    WHERE person = OLD.id AND revoked_us IS NULL;
    UPDATE dataset_share SET person = -1 WHERE person = OLD.id;
END;
