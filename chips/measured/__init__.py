"""What measured models share: tables over temperature and shared shift, deviations, and held-out dies."""
