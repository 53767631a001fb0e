"""A simulated controller that speaks the arm's wire, with the arm in MuJoCo behind it."""
