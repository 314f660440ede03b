"""The coupled system as one linear map a tick."""
