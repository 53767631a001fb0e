"""Tests of connections, lanes and what is under them."""
