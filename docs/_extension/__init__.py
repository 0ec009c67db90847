"""What the site adds to Sphinx: commands that are run, names that are listed, formulas without a script."""
