"""Screens and pages of answers as blocks: a kind of answer a file, made once and rendered everywhere."""
