"""A campaign for people and for other programs: statistics, tables, figures, one page."""
