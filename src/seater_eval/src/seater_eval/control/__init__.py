"""The controller beside others: campaigns, tables, benchmarks."""
