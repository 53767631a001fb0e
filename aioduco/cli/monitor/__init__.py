"""`aioduco monitor`: watch an arm in a terminal, with keys that stop, pause and resume it.

`view_state` holds the data, `screen` renders it; neither needs a terminal or a clock. `observer`
polls the controller, reads the keys and carries out their commands, `monitor` is the command.
"""
