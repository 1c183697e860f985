"""A run in other formats: a trace for ui.perfetto.dev, a report as one HTML file."""
