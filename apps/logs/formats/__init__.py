"""Formats of logs beside text, one a file: ``READERS`` says by which endings each is known."""
