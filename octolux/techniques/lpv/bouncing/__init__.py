"""Further bounces of gathered light: reflected where it arrives, and gathered again."""
