"""Generators of truth: each module has of(recording, folder, options), which gives the Truth of one recording."""
