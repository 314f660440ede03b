"""What the paper says: tables, cases, orders, misprints."""
