"""What the commands do: call, print. What is worth knowing is done elsewhere.

Data goes to stdout, words to stderr; each command returns its exit code.
"""
