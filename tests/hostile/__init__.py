"""Conditions of real life."""
