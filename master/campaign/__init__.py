"""Campaigns: many runs of one system with varied values, in one dataset."""
