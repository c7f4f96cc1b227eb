"""Sentences for acoustic models: the first and second list of the Harvard sentences."""

SENTENCES = (
    "The birch canoe slid on the smooth planks.",
    "Rice is often served in round bowls.",
    "The juice of lemons makes fine punch.",
    "The box was thrown beside the parked truck.",
    "The hogs were fed chopped corn and garbage.",
    "Four hours of steady work faced us.",
    "A large size in stockings is hard to sell.",
    "The boy was there when the sun rose.",
    "Kick the ball straight and follow through.",
    "Glue the sheet to the dark blue background.",
    "It is easy to tell the depth of a well.",
)
