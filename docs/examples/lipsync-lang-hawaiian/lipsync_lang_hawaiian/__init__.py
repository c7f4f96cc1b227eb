"""A folder of packs for lipsync_lang. Nothing in here is run."""
