"""The engine in a web page: the live model, and a user's own collisions beside it."""
