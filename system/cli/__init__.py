"""The command line `noctule`, with a module for each verb."""
