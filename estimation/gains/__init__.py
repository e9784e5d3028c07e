"""Drive gains, torque per motor current, from recordings of currents without and with a known payload."""
