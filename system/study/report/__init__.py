"""Reports of finished studies: statistics, pictures, the worst samples, and the page that holds them."""
