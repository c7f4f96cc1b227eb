"""Quality of animations: measures with limits, and plain methods for comparison."""
