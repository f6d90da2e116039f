"""What all reports share: bars, tables, statistics, the style of figures."""
