"""The paper's figures and claims, from runs of the FMUs, on one page."""
