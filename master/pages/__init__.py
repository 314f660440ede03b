"""HTML pages with plots that work from disk: templates, charts, static pictures."""
