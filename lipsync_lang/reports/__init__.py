"""Reports: what a project has, what it lacks, and how good its animations are."""
