"""Routes of the studio: the requests of the browser, by view.

`table` maps methods and paths to functions of a workshop and a request. A path ends in `{name}` if
its last part is data.
"""
