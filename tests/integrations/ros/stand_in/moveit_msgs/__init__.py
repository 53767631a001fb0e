"""As much of MoveIt's messages as is used, for a machine without MoveIt."""
