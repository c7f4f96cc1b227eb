"""Quality of animations: measures with limits, and plain methods to compare with."""
