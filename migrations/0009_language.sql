-- The language of a person's pages: 'en' or 'nb'; NULL follows what the browser asks for.
ALTER TABLE person ADD COLUMN language TEXT;
