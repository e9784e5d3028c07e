"""Diagnosis of recordings and results: mistakes in logs, causes, checks, the verdict."""
