"""Pictures, the player, and the demo."""
