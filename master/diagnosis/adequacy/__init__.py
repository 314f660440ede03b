"""What is left of a channel, and could anything recorded still predict it?"""
