"""The sections of the manual: the functions that a program calls; and the status port."""
