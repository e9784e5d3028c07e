"""The payload by the four methods of the paper, behind one signature."""
