"""Routes of the studio: the requests of the browser, by view.

Each module has `ROUTES`: method and path to a function of a workshop and a request. A path ends in
`{name}` if its last part is data.
"""
