"""`aioduco demo`: a small pick and place, shown while it runs, and reported at its end.

`script` is the choreography and nothing else. `stage` runs it on a robot and takes the samples,
`view` shows the progress, `report` is the result as data, `plot` draws it.
"""
