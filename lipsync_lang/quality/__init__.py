"""How good an animation is: plain methods to compare with, and what a recording would say."""
