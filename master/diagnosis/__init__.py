"""Measured data: replay, residual, the effect that the model lacks, error before and after."""
