"""What an identifier is, the covariance recursion that several share, and the catalogue of all."""
