-- The account that alone opens a link; null where anyone with its address does.
ALTER TABLE dataset_share ADD COLUMN person INTEGER;

CREATE INDEX dataset_share_person ON dataset_share (person) WHERE person IS NOT NULL;

-- Another account may get the number of one that was removed. What was meant for the first ends with it.
CREATE TRIGGER dataset_share_ends_with_person AFTER DELETE ON person
BEGIN
    UPDATE dataset_share SET revoked_by = OLD.name, revoked_us = CAST(unixepoch('subsec') * 1000000 AS INTEGER)
    WHERE person = OLD.id AND revoked_us IS NULL;
    UPDATE dataset_share SET person = -1 WHERE person = OLD.id;
END;
