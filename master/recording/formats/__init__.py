"""One file a format of recordings; the list of them is in `master/recording/tables.py`."""
