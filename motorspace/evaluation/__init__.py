"""What a finished run is measured at, on data that training never saw."""
