"""Motion planning of the simulated controller: no clock, no thread, no physics, no wire."""
