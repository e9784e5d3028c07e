"""Payload by the four methods of the paper, behind one signature."""
