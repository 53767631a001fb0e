"""`aioduco monitor`: an arm watched in a terminal, by someone with a hand at the stop.

`view_state` is what is known of the arm, `screen` how it looks, both without a terminal or a clock.
`onlooker` asks the controller and carries out what keys ask for, `keyboard` reads them, `monitor`
is the command.
"""
