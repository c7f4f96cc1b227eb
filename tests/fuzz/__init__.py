"""Every reader against inputs that no program wrote: sound files with seeded damage."""
