"""Values: poses, joint vectors, enums, states and triggers; frozen, in SI units."""
