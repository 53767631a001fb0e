"""Programs with the defaults that ship: no test here changes a time or a limit of the package."""
