"""Results of estimators: numbers with intervals, verdicts, and how they came about; each is its own document."""
