-- Counts changes of who may come in. A running server keeps people, sessions, tokens and vessels' names in memory and
-- reads them anew when this count is another, so that nobody waits for this file to be let in or to stop a boat.
CREATE TABLE register (changes INTEGER NOT NULL) STRICT;
INSERT INTO register VALUES (0);

CREATE TRIGGER person_added AFTER INSERT ON person BEGIN UPDATE register SET changes = changes + 1; END;
CREATE TRIGGER person_changed AFTER UPDATE ON person BEGIN UPDATE register SET changes = changes + 1; END;
CREATE TRIGGER person_removed AFTER DELETE ON person BEGIN UPDATE register SET changes = changes + 1; END;
CREATE TRIGGER permission_given AFTER INSERT ON permission BEGIN UPDATE register SET changes = changes + 1; END;
CREATE TRIGGER permission_changed AFTER UPDATE ON permission BEGIN UPDATE register SET changes = changes + 1; END;
CREATE TRIGGER permission_taken AFTER DELETE ON permission BEGIN UPDATE register SET changes = changes + 1; END;
CREATE TRIGGER session_begun AFTER INSERT ON session BEGIN UPDATE register SET changes = changes + 1; END;
CREATE TRIGGER session_ended AFTER DELETE ON session BEGIN UPDATE register SET changes = changes + 1; END;
CREATE TRIGGER token_made AFTER INSERT ON token BEGIN UPDATE register SET changes = changes + 1; END;
CREATE TRIGGER token_revoked AFTER DELETE ON token BEGIN UPDATE register SET changes = changes + 1; END;
CREATE TRIGGER vessel_added AFTER INSERT ON vessel BEGIN UPDATE register SET changes = changes + 1; END;
CREATE TRIGGER vessel_changed AFTER UPDATE ON vessel BEGIN UPDATE register SET changes = changes + 1; END;
CREATE TRIGGER vessel_removed AFTER DELETE ON vessel BEGIN UPDATE register SET changes = changes + 1; END;
