"""The controller as state machines: no clock, no thread, no wire, no physics.

`state_machine.Controller` takes commands between cycles and what the sensors say in each cycle, and
returns what the drives get. May import `planner`, `force`, `cabinet`, `cycle` and `refusal`.
"""
