"""What slipd and plain detectors say on recordings of real sensors, for tools/real."""
