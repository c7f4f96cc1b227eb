"""Scripts: readers of the lines of single engines and programs, each with a logic of its own."""
