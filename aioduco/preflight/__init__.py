"""A program tried against its cell before the arm moves."""
