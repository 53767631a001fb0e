"""Tests of streams: their pure parts, the lane, its end, and what programs see of it."""
