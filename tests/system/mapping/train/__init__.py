"""Tests of `system.mapping.train`."""
