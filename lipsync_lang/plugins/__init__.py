"""Plugins: rooms that register like the packages of others, and that nothing else imports."""
