"""Live characters: text is spoken as it comes, and frames go to an engine while it sounds."""
