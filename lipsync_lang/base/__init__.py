"""Base: what every room may use: errors, arrays, files, plug-ins, and the parts of reports."""
