"""G2P engines and guesses of vowels by packages for single languages or spellings."""
