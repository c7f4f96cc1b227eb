"""Programs: animations in the formats of engines, and of programs for animators and avatars."""
