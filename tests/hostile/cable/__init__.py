"""A program, a controller, and the network between them, which fails."""
