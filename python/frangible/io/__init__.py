"""Files: a writer and a reader for each format."""
