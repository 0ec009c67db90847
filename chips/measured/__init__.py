"""What measured models share: tables over temperature and shared shift, and deviations put on by hand."""
