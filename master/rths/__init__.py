"""The benchmark of real-time hybrid simulation: its records, its plants, its nine measures."""
