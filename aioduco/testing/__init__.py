"""Help for tests of programs that drive an arm: faults on the wire, leaks, waiting."""
