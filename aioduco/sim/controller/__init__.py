"""The controller as state machines: no clock, no thread, no wire, no physics.

`state_machine.Controller` takes commands between cycles. In each cycle it takes the sensors' values
and returns the command to the drives. This package may import `planner`, `force`, `cabinet`,
`cycle` and `refusal`.
"""
