"""The six evenings: what a submission is asked in each, and how answers become points and hints."""
