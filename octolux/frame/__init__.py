"""The passes every technique shares: visibility, G-buffer, shadow maps and RSMs, direct light, composite."""
