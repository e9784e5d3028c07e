"""Three dimensions: an arm in motion as plain values (``moving``), its shapes (``shapes``), and one HTML file."""
