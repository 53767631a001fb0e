"""Tests of streams: their pure parts, the worker, its end, and what programs see of it."""
