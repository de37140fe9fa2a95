-- Alarms that stood when the server ended, so that what somebody acknowledged or shelved stays so. body is an alarm
-- (api::Alarm) as JSON. Times are microseconds since 1970 UTC.
CREATE TABLE alarm (
    id INTEGER PRIMARY KEY,
    body TEXT NOT NULL
) STRICT;
