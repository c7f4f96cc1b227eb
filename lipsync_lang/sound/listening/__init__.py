"""Listening: lips from sound alone, without a text, live or of a whole recording."""
