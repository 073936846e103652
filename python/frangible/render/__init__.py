"""Pictures, films and plots, and the surfaces and materials that all formats show."""
