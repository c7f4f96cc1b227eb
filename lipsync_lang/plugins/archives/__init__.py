"""The command that puts archives of takes together, and makes patches of them."""
