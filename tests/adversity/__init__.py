"""A program that is cancelled, killed or cut off leaves a standing arm and no false answer."""
